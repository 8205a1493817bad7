// Markers of the preview's log: set, reached by keys, and kept in the file beside the log.
#include <cstdio>
#include <utility>

#include <fmt/format.h>

#include "tools/footlight/preview/ui/known_texts.h"
#include "tools/footlight/preview/ui/words.h"

#include "tools/footlight/preview/preview_window.h"

namespace footlight::tools {

void Preview::open_markers() {
  if (!player_ || options_.files.log.empty()) return;  // the demo has no file
  const std::string path = markers_path(options_.files.log);
  Result<Markers> markers = load_markers(path);
  if (!markers) {
    tell(trf("markers are not saved: {}", tr_known(markers.error().message)), true);
    fmt::print(stderr, "footlight: markers are not saved: {}\n", markers.error().message);
    return;
  }
  markers_path_ = path;
  saved_markers_ = *markers;
  desk_->start_markers(std::move(*markers));
}

void Preview::mark_time() {
  if (!player_) return;
  const TimeNs at_ns = controls_.transport.seek_ns.value_or(controls_.transport.now_ns);
  const Status added = desk_->add_marker(at_ns);
  if (!added) return tell(added.error());
  tell(markers_path_.empty() ? trf("a marker at {}; it is not saved", time_text(at_ns))
                             : trf("a marker at {}", time_text(at_ns)));
}

// From where the next marker is searched: where the last seek goes to, or the time that plays. While it plays, back
// means the one before the marker that was passed just now.
TimeNs Preview::marker_start_ns(bool back) const {
  const Transport& transport = controls_.transport;
  if (transport.seek_ns) return *transport.seek_ns;
  return transport.now_ns - (back && transport.playing ? kMarkerPassedNs : 0);
}

void Preview::go_to_marker(const Marker* marker) {
  if (!player_) return;
  if (marker == nullptr) return tell(tr("there is no marker in this direction; M sets one"));
  controls_.transport.seek_ns = marker->at_ns;
  tell(trf("{} at {}", marker->name, time_text(marker->at_ns)));
}

// Once a picture: writes the file after a change. A failure is told once for each change.
void Preview::keep_markers() {
  const Markers& now = desk_->state().markers;
  if (markers_path_.empty() || now == saved_markers_) return;
  saved_markers_ = now;
  if (const Status saved = save_markers(markers_path_, now); !saved) {
    tell(trf("the markers are not saved: {}", tr_known(saved.error().message)), true);
  }
}

}  // namespace footlight::tools
