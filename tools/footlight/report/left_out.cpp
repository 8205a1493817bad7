#include "tools/footlight/report/left_out.h"

#include <algorithm>
#include <memory>

#include <nlohmann/json.hpp>

#include "fixtures/model/features.h"
#include "tools/footlight/report/picture_report.h"

namespace footlight::tools {
namespace {

using namespace render;

constexpr std::int64_t kTimedStepNs = 20 * kNsPerMs;
constexpr int kUncounted = 1;

// GPU times of one frame.
Result<std::vector<PassTime>> time_once(Frame& frame, const Scene& scene, const View& view) {
  frame.step(scene.levels, kTimedStepNs);
  FL_TRY(frame.draw(view, scene.camera.exposure_ev));
  return frame.read_times();
}

// The sum over the named passes. The other passes have the same shaders and inputs in both frames and would only add
// noise.
double sum_of(const std::vector<PassTime>& passes, const std::vector<std::string>& names) {
  double ms = 0;
  for (const PassTime& pass : passes) {
    if (std::find(names.begin(), names.end(), pass.name) != names.end()) ms += pass.gpu_ms;
  }
  return ms;
}

// Names of the passes in `plan` that `from` lacks or has with other constants.
std::vector<std::string> changed(const std::vector<PassPlan>& plan, const std::vector<PassPlan>& from) {
  std::vector<std::string> names;
  for (const PassPlan& pass : plan) {
    if (std::find(from.begin(), from.end(), pass) == from.end()) names.push_back(pass.name);
  }
  return names;
}

std::optional<LeftOutRow::Times> times_of(const std::vector<double>& ms) {
  if (ms.empty()) return std::nullopt;
  return LeftOutRow::Times{percentile(ms, 0.1), percentile(ms, 0.5), percentile(ms, 0.9)};
}

std::uint64_t bytes_of(const std::vector<PassMemory>& plan) {
  std::uint64_t bytes = 0;
  for (const PassMemory& pass : plan) bytes += pass.bytes;
  return bytes;
}

// Measures each missing need against the frame without it.
class Measurement {
 public:
  Measurement(vk::Device& device, const Scene& scene, const LeftOutOptions& options)
      : device_(device), scene_(scene), options_(options), view_(view_of(scene.camera)), settings_(options.settings) {
    plan_ = plan_frame(scene.compiled.needs, settings_);
    memory_ = plan_memory({scene.rig, scene.compiled, scene.compiled.needs, settings_});
    for (const LeftOutPass& pass : left_out_passes(scene.compiled.needs, settings_)) {
      passes_.push_back({.name = pass.name, .text = pass.loss, .pass = true, .on_gpu = false, .times = {}});
    }
  }

  Result<std::vector<LeftOutRow>> rows() {
    std::vector<const fixtures::Feature*> missing;
    for (const fixtures::Feature& feature : fixtures::features()) {
      if (!(scene_.compiled.needs.*feature.need)) missing.push_back(&feature);
    }
    if (options_.runs > 0) {
      FL_ASSIGN(without_, Frame::create(device_, scene_.rig, scene_.compiled, settings_));
    }
    std::vector<LeftOutRow> needs;
    for (const fixtures::Feature* feature : missing) {
      const auto done = static_cast<double>(needs.size());
      if (options_.go_on && !options_.go_on(done, static_cast<double>(missing.size()))) break;
      FL_ASSIGN(LeftOutRow row, measure(*feature));
      needs.push_back(std::move(row));
    }
    std::vector<LeftOutRow> all = passes_;
    all.insert(all.end(), needs.begin(), needs.end());
    return all;
  }

 private:
  Result<LeftOutRow> measure(const fixtures::Feature& feature) {
    LeftOutRow row;
    row.name = feature.name;
    row.text = feature.without;
    fixtures::CompiledRig forced = scene_.compiled;
    forced.needs.*feature.need = true;
    const auto memory = plan_memory({scene_.rig, forced, forced.needs, settings_});
    row.bytes = bytes_of(memory) - std::min(bytes_of(memory_), bytes_of(memory));
    const std::vector<std::string> names = changed(plan_frame(forced.needs, settings_), plan_);
    row.on_gpu = row.bytes > 0 || !names.empty();
    if (!row.on_gpu) return row;
    std::vector<std::vector<double>> pass_ms(passes_.size());
    // Without a floor that mirrors, nothing is mirrored that could be timed.
    if (without_ && feature.need != &fixtures::Needs::gloss) {
      FL_ASSIGN(row.times, measure_times(forced, names, pass_ms));
    }
    for (std::size_t p = 0; p < passes_.size(); ++p) {
      const auto found = std::find_if(memory.begin(), memory.end(),
                                      [&](const PassMemory& each) { return each.name == passes_[p].name; });
      if (found == memory.end() || passes_[p].on_gpu) continue;
      passes_[p].on_gpu = true;
      passes_[p].bytes = found->bytes;
      passes_[p].times = times_of(pass_ms[p]);
    }
    return row;
  }

  // Returns the times of the passes in `names` together, and writes those of each of passes_ to pass_ms.
  Result<std::optional<LeftOutRow::Times>> measure_times(const fixtures::CompiledRig& forced,
                                                         const std::vector<std::string>& names,
                                                         std::vector<std::vector<double>>& pass_ms) {
    FL_ASSIGN(const auto with, Frame::create(device_, scene_.rig, forced, settings_));
    std::vector<double> more_ms;
    for (int i = -kUncounted; i < options_.runs; ++i) {
      FL_ASSIGN(const auto less, time_once(*without_, scene_, view_));
      FL_ASSIGN(const auto more, time_once(*with, scene_, view_));
      if (i < 0 || more.empty()) continue;
      more_ms.push_back(sum_of(more, names) - sum_of(less, names));
      for (std::size_t p = 0; p < passes_.size(); ++p) {
        for (const PassTime& time : more) {
          if (time.name == passes_[p].name) pass_ms[p].push_back(time.gpu_ms);
        }
      }
    }
    return times_of(more_ms);
  }

  vk::Device& device_;
  const Scene& scene_;
  const LeftOutOptions& options_;
  View view_;
  FrameSettings settings_;
  std::vector<PassPlan> plan_;
  std::vector<PassMemory> memory_;
  std::vector<LeftOutRow> passes_;
  std::unique_ptr<Frame> without_;  // null: nothing is timed
};

std::string bytes_text(std::uint64_t bytes) {
  if (bytes < std::uint64_t{10} * 1024) return fmt::format("{} B", bytes);
  if (bytes < std::uint64_t{10} * 1024 * 1024) return fmt::format("{:.1f} KiB", static_cast<double>(bytes) / 1024);
  return fmt::format("{:.1f} MiB", static_cast<double>(bytes) / (1024 * 1024));
}

}  // namespace

Result<std::vector<LeftOutRow>> measure_left_out(vk::Device& device, const Scene& scene,
                                                 const LeftOutOptions& options) {
  return Measurement(device, scene, options).rows();
}

std::string text_of(const std::vector<LeftOutRow>& rows, const std::string& scene) {
  const bool timed = std::any_of(rows.begin(), rows.end(), [](const LeftOutRow& row) { return row.times.has_value(); });
  std::string text =
      fmt::format("Left out, because {} does not need it, with the GPU memory that each would use{}:\n", scene,
                  timed ? " and the GPU time of the frame with it minus without it (median of pairs, p10 "
                          "to p90)"
                        : "; not timed");
  for (const LeftOutRow& row : rows) {
    text += fmt::format("  {}{}: {}", row.pass ? "pass " : "", row.name, row.text);
    if (!row.on_gpu) {
      text += "; nothing on the GPU\n";
      continue;
    }
    if (row.times) {
      text += fmt::format("; {:+.3f} ms ({:+.3f} to {:+.3f})", row.times->ms_p50, row.times->ms_p10, row.times->ms_p90);
    }
    text += fmt::format(", {}\n", bytes_text(row.bytes));
  }
  return rows.empty() ? text + "  nothing\n" : text;
}

std::string json_of(const std::vector<LeftOutRow>& rows) {
  std::string text;
  for (const LeftOutRow& row : rows) {
    nlohmann::json line = {{"event", "left-out"},
                           {row.pass ? "pass" : "need", row.name},
                           {"without", row.text},
                           {"on_gpu", row.on_gpu},
                           {"bytes", row.bytes}};
    if (row.times) {
      line["ms_p10"] = row.times->ms_p10;
      line["ms_p50"] = row.times->ms_p50;
      line["ms_p90"] = row.times->ms_p90;
    }
    text += line.dump() + "\n";
  }
  return text;
}

}  // namespace footlight::tools
