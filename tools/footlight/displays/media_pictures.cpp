#include "tools/footlight/displays/media_pictures.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "sim/core/counted.h"
#include "sim/core/no_signals.h"

namespace footlight::tools {
namespace {

// The content in the pixels of what shows it.
fixtures::Display sized_content(const fixtures::Display& content, int columns, int rows) {
  fixtures::Display sized = content;
  sized.columns = columns;
  sized.rows = rows;
  return sized;
}

// Pixels of a content that a layer scales or moves: its own, so that they are there where it is larger. A video has
// at least these.
constexpr int kPlacedVideoColumns = 960, kPlacedVideoRows = 540;
glm::ivec2 pixels_of(const fixtures::Media& media, const fixtures::MediaLayer& layer, const glm::ivec2& shown) {
  if (!layer.is_placed && media.place == fixtures::PicturePlace{}) return shown;
  const fixtures::Display& content = media.content;
  if (content.video) return glm::max(shown, glm::ivec2(kPlacedVideoColumns, kPlacedVideoRows));
  if (content.image) return {content.image->width, content.image->height};
  return content.map ? glm::ivec2(content.columns, content.rows) : glm::ivec2(1);
}

// The time of the file of a layer that has played for so long: from its begin to its end.
DurationNs file_time_ns(const fixtures::DisplayVideo& video, const fixtures::MediaLayer& layer,
                        DurationNs duration_ns) {
  fixtures::DisplayVideo played = video;
  played.loop = layer.loop.value_or(video.loop);
  const auto whole = static_cast<double>(duration_ns);
  const auto begin_ns = std::min<DurationNs>(std::llround(layer.begin * whole), duration_ns - 1);
  const auto end_ns = std::clamp<DurationNs>(std::llround(layer.end * whole), begin_ns + 1, duration_ns);
  return begin_ns + clip_time_ns(played, layer.played_ns, end_ns - begin_ns);
}

}  // namespace

std::string damage_news(const std::string& path, std::size_t replaced) {
  return fmt::format("{}: {} so far cannot be decoded; the last whole one stays in their place. Export the video again",
                     path, counted(replaced, "picture"));
}

Result<MediaPictures> MediaPictures::open(const fixtures::Rig& rig, ClipPace pace, std::uint64_t bytes_kept) {
  MediaPictures pictures;
  pictures.pace_ = pace;
  pictures.bytes_kept_ = bytes_kept;
  for (const fixtures::PatchedFixture& fixture : rig.fixtures) {
    if (!fixture.media) continue;
    for (const fixtures::Media& media : fixture.media->media) {
      if (!media.content.video) continue;
      if (const auto clip = Clip::open(media.content.video->path); !clip) {
        return fail(clip.error().code, "[[fixture]] {}: media: video: {}", fixture.name, clip.error().message);
      }
    }
  }
  return pictures;
}

MediaPictures::Source MediaPictures::make(const Key& key, const fixtures::MediaPlayer& player) const {
  const auto columns = std::get<2>(key), rows = std::get<3>(key);
  const fixtures::Display& content = *std::get<1>(key);
  Source source;
  source.key = key;
  if (content.map) {
    source.universes = player.universes();
    source.map.emplace(content, source.universes);
  } else if (content.video) {
    source.path = content.video->path;
    const NoSignals no_signals;
    source.opening =
        std::async(std::launch::async, [sized = sized_content(content, columns, rows), pace = pace_] {
          return ClipFeed::open(sized, pace);
        });
  } else if (content.image) {
    const bool as_it_is = content.image->width == columns && content.image->height == rows;
    source.pixels = as_it_is ? content.image
                             : std::make_shared<const fixtures::PaneImage>(resampled(*content.image, columns, rows));
  } else {
    fixtures::PaneImage even{columns, rows, {}};
    even.texels.assign(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), glm::vec3(1));
    source.pixels = std::make_shared<const fixtures::PaneImage>(std::move(even));
  }
  return source;
}

Status MediaPictures::update_clip(Source& source, const fixtures::MediaLayer& layer) {
  if (source.failed) return {};
  if (!source.clip) {
    const bool waits = pace_ == ClipPace::kExact;
    if (!waits && source.opening.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return {};
    auto opened = source.opening.get();
    source.failed = !opened;
    if (!opened) return tl::unexpected<Error>(opened.error());
    source.clip = std::move(*opened);
  }
  const fixtures::DisplayVideo& video = *std::get<1>(source.key)->video;
  const auto light = source.clip->at_clip(file_time_ns(video, layer, source.clip->duration_ns()));
  source.failed = !light;
  source.pixels = light ? light->pixels : nullptr;
  return light ? Status{} : Status(tl::unexpected<Error>(light.error()));
}

Status MediaPictures::update(Source& source, const fixtures::MediaLayer& layer, const fixtures::MediaPlayer& player) {
  source.used = true;
  if (!source.path.empty()) return update_clip(source, layer);
  if (!source.map) return {};
  if (const auto pixels = source.map->next(player.levels())) {
    source.pixels = std::make_shared<const fixtures::PaneImage>(
        resampled(*pixels, std::get<2>(source.key), std::get<3>(source.key)));
  }
  return {};
}

MediaPictures::Placed MediaPictures::placed(const std::shared_ptr<const fixtures::PaneImage>& from,
                                           const fixtures::PictureMap& map,
                                           const fixtures::MediaPlayer::Show& show, const Given& before) {
  const bool fills = fixtures::is_identity(map);
  if (!from || (fills && from->width == show.columns && from->height == show.rows)) return {from, map, from, nullptr};
  for (const Placed& each : before.placed) {
    if (each.from == from && each.map == map) return each;
  }
  fixtures::MappedPicture made = mapped(*from, map, show.columns, show.rows);
  Placed placed{from, map, std::make_shared<const fixtures::PaneImage>(std::move(made.light)), nullptr};
  if (!fills) placed.cover = std::make_shared<const std::vector<float>>(std::move(made.cover));
  return placed;
}

Status MediaPictures::give_changes(const fixtures::MediaPlayer& player, const GivePixels& give) {
  Status status;
  given_.resize(player.shows().size());
  std::erase_if(sources_, [&](const Source& each) { return each.map && each.universes != player.universes(); });
  for (Source& source : sources_) source.used = false;
  for (std::size_t s = 0; s < player.shows().size(); ++s) {
    const fixtures::MediaPlayer::Show& show = player.shows()[s];
    Given now;
    now.share = player.shares()[show.dimmed];
    for (const std::size_t l : show.layers) {
      const fixtures::MediaLayer& layer = player.layers()[l];
      if (layer.media < 0) continue;
      const fixtures::Media& media = show.server->media[static_cast<std::size_t>(layer.media)];
      const glm::ivec2 pixels = pixels_of(media, layer, {show.columns, show.rows});
      const Key key(l, &media.content, pixels.x, pixels.y);
      auto source = std::find_if(sources_.begin(), sources_.end(), [&](const Source& each) { return each.key == key; });
      if (source == sources_.end()) {
        source = sources_.insert(sources_.end(), make(key, player));
        source->server = show.server;
      }
      if (Status updated = update(*source, layer, player); !updated && status) status = updated;
      const fixtures::PictureMap map = map_of(layer.place, show.aspect) * map_of(media.place, show.aspect);
      // A dark layer is read, so that it is there once it is faded in, but not moved.
      now.placed.push_back(layer.share > 0 ? placed(source->pixels, map, show, given_[s]) : Placed{});
      const Placed& there = now.placed.back();
      now.layers.push_back({there.pixels, there.cover, layer.share, layer.color * media.content.color, layer.blend});
    }
    if (given_[s].share == now.share && given_[s].layers == now.layers) continue;
    give(show.shown,
         std::make_shared<const fixtures::PaneImage>(composed(now.layers, now.share, show.columns, show.rows)));
    given_[s] = std::move(now);
  }
  if (sources_.size() > kSourcesKept || bytes() > bytes_kept_) {
    std::erase_if(sources_, [](const Source& source) { return !source.used; });
  }
  return status;
}

std::uint64_t MediaPictures::Source::bytes() const {
  if (clip) return clip->bytes_most();
  const bool is_own = pixels && pixels != std::get<1>(key)->image;
  return is_own ? pixels->texels.size() * sizeof(glm::vec3) : 0;
}

std::uint64_t MediaPictures::bytes() const {
  std::uint64_t sum = 0;
  for (const Source& source : sources_) sum += source.bytes();
  return sum;
}

std::vector<std::string> MediaPictures::take_news() {
  std::vector<std::string> news;
  for (Source& source : sources_) {
    const std::size_t replaced = source.told || !source.clip ? 0 : source.clip->replaced();
    if (replaced == 0) continue;
    source.told = true;
    news.push_back(damage_news(source.path, replaced));
  }
  return news;
}

Status hold_media(fixtures::Rig& rig, const fixtures::MediaPlayer& player) {
  MediaPictures pictures;
  const std::size_t displays = rig.displays.size();
  const GivePixels hold = [&](std::size_t shown, const std::shared_ptr<const fixtures::PaneImage>& pixels) {
    (shown < displays ? rig.displays[shown] : rig.projections[shown - displays]).image = pixels;
  };
  return pictures.give_changes(player, hold);
}

}  // namespace footlight::tools
