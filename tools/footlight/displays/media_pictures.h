// The pixels of what shows media servers: their layers over each other, each with an image, a video or a pixel map.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "fixtures/displays/map_film.h"
#include "fixtures/media/media_player.h"
#include "fixtures/media/media_server.h"
#include "tools/footlight/displays/clip_feed.h"

namespace footlight::tools {

// Contents that are shown nowhere are kept until there are more, or more bytes of their light.
inline constexpr std::size_t kSourcesKept = 16;
inline constexpr std::uint64_t kSourceBytesKept = std::uint64_t{1} << 30;

// Takes columns x rows pixels of what fixtures::shown_at() is of a rig.
using GivePixels = std::function<void(std::size_t shown, const std::shared_ptr<const fixtures::PaneImage>& pixels)>;

// What is said of a video in which pictures are damaged.
[[nodiscard]] std::string damage_news(const std::string& path, std::size_t replaced);

class MediaPictures {
 public:
  // Reads each video of the media servers once, so that one that cannot be shown is an error here: that of
  // Clip::open(), with the name of the server. With kAhead a video is opened by a thread when it is first chosen, and
  // the layer shows nothing until then.
  [[nodiscard]] static Result<MediaPictures> open(const fixtures::Rig& rig, ClipPace pace,
                                                  std::uint64_t bytes_kept = kSourceBytesKept);

  // Calls `give` for each of the shows of the player whose pixels have changed. Error: of the first video that cannot
  // be decoded; its layer shows nothing from then on.
  Status give_changes(const fixtures::MediaPlayer& player, const GivePixels& give);
  // The next give_changes() gives everything.
  void show_all_again() { given_.clear(); }
  // Of the light of all contents that it has; of videos as much as they may get.
  [[nodiscard]] std::uint64_t bytes() const;
  // As DisplayVideos::take_news().
  [[nodiscard]] std::vector<std::string> take_news();

 private:
  using Opening = std::future<Result<std::unique_ptr<ClipFeed>>>;
  using Key = std::tuple<std::size_t, const fixtures::Display*, int, int>;  // layer, content, columns, rows
  // A content in the pixels of what shows it, for one layer of one server.
  struct Source {
    Key key;
    std::shared_ptr<const fixtures::MediaServer> server;  // keeps the content
    std::shared_ptr<const fixtures::PaneImage> pixels;
    std::unique_ptr<ClipFeed> clip;
    Opening opening;
    std::optional<fixtures::MapFilm> map;
    std::vector<Universe> universes;  // of the levels that the map reads
    std::string path;  // of the video
    bool failed = false;
    bool told = false;
    bool used = true;
    [[nodiscard]] std::uint64_t bytes() const;
  };
  // A layer in the pixels of what shows it.
  struct Placed {
    std::shared_ptr<const fixtures::PaneImage> from;
    fixtures::PictureMap map{1};
    std::shared_ptr<const fixtures::PaneImage> pixels;
    std::shared_ptr<const std::vector<float>> cover;
  };
  struct Given {
    std::vector<fixtures::MediaPixels> layers;
    std::vector<Placed> placed;  // one each of layers
    double share = -1;
  };
  // That of `before`, if nothing has changed.
  [[nodiscard]] static Placed placed(const std::shared_ptr<const fixtures::PaneImage>& from,
                                     const fixtures::PictureMap& map, const fixtures::MediaPlayer::Show& show,
                                     const Given& before);
  [[nodiscard]] Source make(const Key& key, const fixtures::MediaPlayer& player) const;
  Status update(Source& source, const fixtures::MediaLayer& layer, const fixtures::MediaPlayer& player);
  Status update_clip(Source& source, const fixtures::MediaLayer& layer);

  ClipPace pace_ = ClipPace::kExact;
  std::uint64_t bytes_kept_ = kSourceBytesKept;
  std::vector<Source> sources_;
  std::vector<Given> given_;  // one each of the shows
};

// Gives displays and projectors the picture of their media servers, which then stands: for the judge.
[[nodiscard]] Status hold_media(fixtures::Rig& rig, const fixtures::MediaPlayer& player);

}  // namespace footlight::tools
