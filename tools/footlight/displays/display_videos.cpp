#include "tools/footlight/displays/display_videos.h"

#include <algorithm>
#include <utility>

#include "fixtures/media/media_server.h"

namespace footlight::tools {
namespace {

bool is_video(const fixtures::Display& display) { return display.video && !display.image; }

// Whether the same media servers show on the same displays.
bool same_media(const fixtures::Rig& a, const fixtures::Rig& b) {
  const auto all = [](const fixtures::Rig& rig) {
    std::vector<std::pair<std::string, const fixtures::MediaServer*>> servers;
    for (const fixtures::PatchedFixture& each : rig.fixtures) {
      if (each.media) servers.emplace_back(each.name, each.media.get());
    }
    return servers;
  };
  return all(a) == all(b);
}

bool same_film(const fixtures::Display& a, const fixtures::Display& b) {
  const fixtures::DisplayVideo &x = *a.video, &y = *b.video;
  return a.columns == b.columns && a.rows == b.rows && x.path == y.path && x.start_s == y.start_s &&
         x.speed == y.speed && x.loop == y.loop && x.gamma == y.gamma;
}

}  // namespace

Result<DisplayVideos> DisplayVideos::open(const fixtures::Rig& rig, ClipPace pace) {
  DisplayVideos videos;
  FL_ASSIGN(videos.media_, MediaPictures::open(rig, pace));
  for (std::size_t i = 0; i < fixtures::shown_count(rig); ++i) {
    const fixtures::Display& display = fixtures::shown_at(rig, i);
    if (!is_video(display)) continue;
    const auto same = std::find_if(videos.feeds_.begin(), videos.feeds_.end(), [&](const Feed& feed) {
      return same_film(fixtures::shown_at(rig, feed.displays.front()), display);
    });
    if (same != videos.feeds_.end()) {
      same->displays.push_back(i);
      continue;
    }
    auto feed = ClipFeed::open(display, pace);
    if (!feed) {
      return fail(feed.error().code, "[[{}]] {}: video: {}", display.type >= 0 ? "projector" : "display", display.name,
                  feed.error().message);
    }
    videos.feeds_.push_back({std::move(*feed), display.video->path, {i}, nullptr, false});
  }
  return videos;
}

Status DisplayVideos::show(DurationNs show_ns, render::Frame& frame) {
  const GivePixels give = [&](std::size_t display, const std::shared_ptr<const fixtures::PaneImage>& pixels) {
    frame.show_pixels(display, pixels);
  };
  Status shown = give_changes(show_ns, give);
  if (frame.media() == nullptr) return shown;
  Status media = media_.give_changes(*frame.media(), give);
  return shown ? media : shown;
}

Status DisplayVideos::give_changes(DurationNs show_ns, const GivePixels& give) {
  Status status;
  for (auto feed = feeds_.begin(); feed != feeds_.end();) {
    const auto light = feed->feed->at(show_ns);
    if (!light) {
      if (status) status = tl::unexpected<Error>(light.error());
      feed = feeds_.erase(feed);
      continue;
    }
    if (light->pixels && light->pixels != feed->shown) {
      for (const std::size_t display : feed->displays) give(display, light->pixels);
      feed->shown = light->pixels;
    }
    ++feed;
  }
  return status;
}

void DisplayVideos::show_all_again() {
  for (Feed& feed : feeds_) feed.shown.reset();
  media_.show_all_again();
}

std::vector<std::string> DisplayVideos::take_news() {
  std::vector<std::string> news = media_.take_news();
  for (Feed& feed : feeds_) {
    const std::size_t replaced = feed.told ? 0 : feed.feed->replaced();
    if (replaced == 0) continue;
    feed.told = true;
    news.push_back(damage_news(feed.path, replaced));
  }
  return news;
}

bool same_videos(const fixtures::Rig& a, const fixtures::Rig& b) {
  if (!same_media(a, b)) return false;
  if (a.displays.size() != b.displays.size() && !(a.projections.empty() && b.projections.empty())) return false;
  for (std::size_t i = 0; i < std::max(fixtures::shown_count(a), fixtures::shown_count(b)); ++i) {
    const auto is_film = [&](const fixtures::Rig& rig) {
      return i < fixtures::shown_count(rig) && is_video(fixtures::shown_at(rig, i));
    };
    if (is_film(a) != is_film(b)) return false;
    if (is_film(a) && !same_film(fixtures::shown_at(a, i), fixtures::shown_at(b, i))) return false;
  }
  return true;
}

Status hold_videos(fixtures::Rig& rig, DurationNs show_ns) {
  for (std::vector<fixtures::Display>* const all : {&rig.displays, &rig.projections}) {
    for (fixtures::Display& display : *all) {
      if (!is_video(display)) continue;
      FL_ASSIGN(const auto feed, ClipFeed::open(display, ClipPace::kExact));
      FL_ASSIGN(const ClipLight light, feed->at(show_ns));
      display.image = light.pixels;
    }
  }
  return {};
}

}  // namespace footlight::tools
