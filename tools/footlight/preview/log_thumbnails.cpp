#include "tools/footlight/preview/log_thumbnails.h"

#include <utility>

namespace footlight::tools {
namespace {

constexpr DurationNs kExposureNs = 20 * kNsPerMs;
constexpr DurationNs kRestTimes = 16;
constexpr DurationNs kRestTimesPaused = 4;

}  // namespace

bool LogThumbnails::is_due(TimeNs now_ns, const SeekIndex* index, DurationNs duration_ns,
                           bool paused) const {
  if (now_ns - ended_ns_ < took_ns_ * (paused ? kRestTimesPaused : kRestTimes)) return false;
  return index != nullptr && pictures_.next(duration_ns, index->known_ns()).has_value();
}

Status LogThumbnails::begin(TimeNs now_ns, render::vk::Device& device, render::Frame& frame, const SeekIndex& index,
                            DurationNs duration_ns, const Scene& scene) {
  const auto at_ns = pictures_.next(duration_ns, index.known_ns());
  if (!at_ns) return {};
  pictures_.pass_over(*at_ns);
  const SeekIndex::Moment* moment = index.before(*at_ns);
  if (moment == nullptr && !index.moments().empty()) moment = &index.moments().front();
  if (moment == nullptr || pictures_.nearest(moment->position.now_ns, 0) != nullptr) return {};
  begun_ns_ = now_ns;
  if (!picture_) {
    FL_ASSIGN(picture_, StagePicture::make(device));
  }
  if (!small_) {
    render::FrameSettings settings = frame.settings();
    settings.width = Thumbnails::kWidth;
    settings.height = Thumbnails::kHeight;
    settings.supersample = 1;
    settings.edge_samples = 0;
    settings.auto_exposure = false;
    settings.probe_texels = FL_PROBE_TEXELS;  // what it mirrors is of its own moment
    FL_ASSIGN(small_, render::Frame::create_beside(frame, settings));
  }
  at_ns_ = moment->position.now_ns;
  FL_ASSIGN(shown_, frame.save_state());
  FL_TRY(frame.load_state(moment->state));
  frame.step(moment->position.levels, kExposureNs, true);
  FL_TRY(frame.run_steps());
  small_->follow(frame);
  small_->set_work_light_lx(scene.work_light_lx);
  return picture_->begin(small_->resources().picture.screen.handle, Thumbnails::kWidth, Thumbnails::kHeight,
                         [&](VkCommandBuffer commands) {
                           small_->record(commands, render::view_of(scene.camera), scene.camera.exposure_ev);
                         });
}

Status LogThumbnails::finish(TimeNs now_ns, render::Frame& frame) {
  pictures_.add(at_ns_, picture_->take().rgba);
  took_ns_ = now_ns - begun_ns_;
  ended_ns_ = now_ns;
  return frame.load_state(std::exchange(shown_, {}));
}

void LogThumbnails::drop_frame() {
  picture_.reset();
  small_.reset();
}

void LogThumbnails::clear() {
  drop_frame();
  pictures_ = {};
}

}  // namespace footlight::tools
