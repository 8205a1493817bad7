#include "render/live_error.h"

#include <array>
#include <cmath>

#include "render/passes/surfaces.h"
#include "shaders/hazerecheck.comp.h"
#include "shaders/recheck.comp.h"

namespace footlight::render {
namespace {

constexpr std::uint32_t kCells = FL_RECHECK_X * FL_RECHECK_Y;
// A CPU takes as long for 128 pixels with gobos as for the picture, so it computes a sixteenth of the cells each time.
constexpr std::uint32_t kCellsOfCpu = 8;
constexpr double kNormal95 = 1.959964;

}  // namespace

void ErrorWindow::add(TimeNs now_ns, std::span<const RecheckRow> rows) {
  Picture picture{now_ns, {}};
  for (const RecheckRow& row : rows) {
    if (!(row.weight > 0)) continue;
    Sample sample;
    for (int c = 0; c < 3; ++c) {
      const double r = static_cast<double>(row.general[c]);
      const double x = std::isfinite(row.shown[c]) ? static_cast<double>(row.shown[c]) : 0;
      sample.error += static_cast<double>(row.weight) * (x - r) * (x - r);
      sample.square += static_cast<double>(row.weight) * r * r;
    }
    if (std::isfinite(sample.error) && std::isfinite(sample.square)) picture.samples.push_back(sample);
  }
  pictures_.push_back(std::move(picture));
  samples_ += pictures_.back().samples.size();
  while (pictures_.size() > kPicturesMax || (pictures_.front().at_ns < now_ns - kWindowNs &&
                                             samples_ - pictures_.front().samples.size() >= samples_min_)) {
    samples_ -= pictures_.front().samples.size();
    pictures_.pop_front();
  }
}

ErrorWindow::Estimate ErrorWindow::estimate() const {
  Estimate estimate;
  double error = 0;
  double square = 0;
  for (const Picture& picture : pictures_) {
    estimate.samples += picture.samples.size();
    for (const Sample& sample : picture.samples) {
      error += sample.error;
      square += sample.square;
    }
  }
  if (!(square > 0)) return estimate;
  const double ratio = error / square;
  double residuals = 0;
  for (const Picture& picture : pictures_) {
    for (const Sample& sample : picture.samples) {
      const double residual = sample.error - ratio * sample.square;
      residuals += residual * residual;
    }
  }
  estimate.rel_l2 = std::sqrt(ratio);
  if (!(error > 0)) return estimate;
  const double half = kNormal95 * std::sqrt(residuals) / error;  // of the logarithm of the ratio
  estimate.low = estimate.rel_l2 * std::exp(-half / 2);
  estimate.high = estimate.rel_l2 * std::exp(half / 2);
  return estimate;
}

namespace {

// The general path mirrors nothing, dims nothing behind plumes and blurs nothing.
bool measurable(const fixtures::Needs& needs, const FrameSettings& settings) {
  return !has_gloss(needs, settings) && !has_depth_of_field(needs, settings) && !needs.plumes;
}

}  // namespace

Result<std::shared_ptr<const vk::Pipeline>> LiveError::begin_pipeline(vk::Device& device, const FrameSettings& settings,
                                                                      const fixtures::Needs& needs) {
  std::vector<vk::SpecConstant> constants = kSurfacesPass.constants(needs, settings);
  constants.push_back({FL_SPEC_GOBO_TAPS, 1024});
  constants.push_back({FL_SPEC_PROBES, has_probes(needs, settings)});
  constants.push_back({FL_SPEC_EDGES, has_smooth_edges(needs, settings)});
  return device.pipelines().begin_compute(
      has_haze_field(needs, settings) ? vk::Spirv(kHazerecheckComp) : vk::Spirv(kRecheckComp), constants);
}

void LiveError::compile_ahead(vk::Device& device, const FrameSettings& settings, const fixtures::Needs& needs) {
  if (measurable(needs, settings)) (void)begin_pipeline(device, settings, needs);  // create() fails, too
}

Result<std::unique_ptr<LiveError>> LiveError::create(vk::Device& device, Frame& frame, const fixtures::Needs& needs) {
  const FrameSettings& settings = frame.settings();
  fixtures::Needs all = needs;
  if (frame.resources().rig.sheen_count > 0) all.sheen = true;  // as Frame::create() does
  if (!measurable(needs, settings)) return std::unique_ptr<LiveError>();
  std::unique_ptr<LiveError> live(new LiveError(device));
  live->cells_ = device.is_software() ? kCellsOfCpu : kCells;
  FL_ASSIGN(live->pipeline_, begin_pipeline(device, settings, all));
  FL_TRY(device.pipelines().finish());
  constexpr VkDeviceSize kBytes = kCells * sizeof(RecheckRow);
  FL_ASSIGN(live->rechecked_, vk::Buffer::device_local(device, kBytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT));
  FL_ASSIGN(live->read_, vk::Buffer::host_visible(device, kBytes, 0));
  vk::BindingTable table = frame.resources().bindings;
  table.set_buffer(FL_BINDING_RECHECKED, live->rechecked_);
  for (const vk::ShaderBinding& binding : live->pipeline_->shader().bindings) {
    if (table.find(binding.binding) == nullptr) return std::unique_ptr<LiveError>();
  }
  FL_ASSIGN(live->set_, vk::BindingSet::create(device, *live->pipeline_, table));
  if (device.facts().timestamp_bits > 0) {
    VkQueryPoolCreateInfo query{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    query.queryType = VK_QUERY_TYPE_TIMESTAMP;
    query.queryCount = 2;
    FL_TRY(vk::check(vkCreateQueryPool(device.handle, &query, nullptr, &live->times_), "vkCreateQueryPool"));
  }
  return live;
}

LiveError::~LiveError() {
  (void)device_.wait_idle();
  if (times_ != VK_NULL_HANDLE) vkDestroyQueryPool(device_.handle, times_, nullptr);
}

void LiveError::record(VkCommandBuffer commands) {
  const auto mark = [&](std::uint32_t number) {
    if (times_ == VK_NULL_HANDLE) return;
    vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, times_, number);
  };
  vk::full_barrier(commands);
  if (times_ != VK_NULL_HANDLE) vkCmdResetQueryPool(commands, times_, 0, 2);
  mark(0);
  vk::full_barrier(commands);
  pipeline_->bind(commands, set_);
  const std::array<std::uint32_t, 2> push{seed_, seed_ * cells_};
  ++seed_;
  pipeline_->push(commands, std::as_bytes(std::span(push)));
  vkCmdDispatch(commands, cells_, 1, 1);
  mark(1);
  vk::full_barrier(commands);
  const VkBufferCopy region{0, 0, read_.size_bytes};
  vkCmdCopyBuffer(commands, rechecked_.handle, read_.handle, 1, &region);
  vk::host_barrier(commands);
}

std::span<const RecheckRow> LiveError::rows() const { return {static_cast<const RecheckRow*>(read_.mapped), cells_}; }

Status LiveError::take(TimeNs now_ns) {
  window_.add(now_ns, rows());
  if (times_ == VK_NULL_HANDLE) return {};
  std::array<std::uint64_t, 2> ticks{};
  FL_TRY(vk::check(vkGetQueryPoolResults(device_.handle, times_, 0, 2, sizeof(ticks), ticks.data(), 8,
                                         VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
                   "vkGetQueryPoolResults"));
  const std::uint32_t bits = device_.facts().timestamp_bits;
  const std::uint64_t mask = bits < 64 ? (std::uint64_t{1} << bits) - 1 : ~std::uint64_t{0};
  gpu_ms_ = static_cast<double>((ticks[1] - ticks[0]) & mask) * device_.timestamp_period_ns() * 1e-6;
  return {};
}

}  // namespace footlight::render
