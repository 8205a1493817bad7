#include "tools/footlight/report/left_out.h"

#include <algorithm>
#include <memory>
#include <set>
#include <utility>

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

// SPIR-V of each pass, needed or not. Stages that several of its pipelines have count once.
std::vector<PassMemory> code_sizes() {
  std::vector<PassMemory> sizes;
  for (const PassShaders& pass : pass_shaders()) {
    std::set<const std::uint32_t*> counted;
    sizes.push_back({pass.name, 0});
    for (const auto& stages : pass.pipelines) {
      for (const vk::Spirv stage : stages) {
        if (counted.insert(stage.data()).second) sizes.back().bytes += stage.size_bytes();
      }
    }
  }
  return sizes;
}

std::vector<const fixtures::Feature*> missing_features(const fixtures::Needs& needs) {
  std::vector<const fixtures::Feature*> missing;
  for (const fixtures::Feature& feature : fixtures::features()) {
    if (!(needs.*feature.need)) missing.push_back(&feature);
  }
  return missing;
}

// Rows of passes that are left out, with their code.
std::vector<LeftOutRow> pass_rows(const fixtures::Needs& needs, const FrameSettings& settings) {
  std::vector<LeftOutRow> rows;
  const auto all = code_sizes();
  for (const LeftOutPass& pass : left_out_passes(needs, settings)) {
    rows.push_back({.name = pass.name, .text = pass.loss, .pass = true, .on_gpu = false, .times = {}});
    const auto code = std::find_if(all.begin(), all.end(), [&](const auto& each) { return each.name == pass.name; });
    if (code != all.end()) rows.back().code_bytes = code->bytes;
  }
  return rows;
}

// The frame without a need, and what the need would change of it.
struct Without {
  MemoryShape shape;
  std::vector<PassPlan> plan;
  std::vector<PassMemory> memory;
  explicit Without(const MemoryShape& of)
      : shape(of), plan(plan_frame(of.needs, of.settings)), memory(plan_memory(of)) {}

  struct Change {
    LeftOutRow row;
    std::vector<std::string> names;  // of the passes that it adds or changes
    std::vector<PassMemory> memory;  // with it
  };
  [[nodiscard]] Change with(const fixtures::Feature& feature) const {
    Change change;
    MemoryShape forced = shape;
    forced.needs.*feature.need = true;
    change.memory = plan_memory(forced);
    change.names = changed(plan_frame(forced.needs, forced.settings), plan);
    change.row.name = feature.name;
    change.row.text = feature.without;
    change.row.bytes = bytes_of(change.memory) - std::min(bytes_of(memory), bytes_of(change.memory));
    change.row.on_gpu = change.row.bytes > 0 || !change.names.empty();
    return change;
  }
};

// The bytes of a pass are those of the first need that brings it. True: this one does.
bool take_bytes(LeftOutRow& pass, const std::vector<PassMemory>& memory) {
  const auto found =
      std::find_if(memory.begin(), memory.end(), [&](const PassMemory& each) { return each.name == pass.name; });
  if (found == memory.end() || pass.on_gpu) return false;
  pass.on_gpu = true;
  pass.bytes = found->bytes;
  return true;
}

// Measures each missing need against the frame without it.
class Measurement {
 public:
  Measurement(vk::Device& device, const Scene& scene, const LeftOutOptions& options)
      : device_(device),
        scene_(scene),
        options_(options),
        view_(view_of(scene.camera)),
        settings_(options.settings),
        base_({scene.rig, scene.compiled, scene.compiled.needs, settings_}),
        passes_(pass_rows(scene.compiled.needs, settings_)) {}

  Result<std::vector<LeftOutRow>> rows() {
    const std::vector<const fixtures::Feature*> missing = missing_features(scene_.compiled.needs);
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
    Without::Change change = base_.with(feature);
    LeftOutRow row = std::move(change.row);
    if (!row.on_gpu) return row;
    std::vector<std::vector<double>> pass_ms(passes_.size());
    // Without a floor that mirrors, nothing is mirrored that could be timed.
    if (without_ && feature.need != &fixtures::Needs::gloss) {
      fixtures::CompiledRig forced = scene_.compiled;
      forced.needs.*feature.need = true;
      FL_ASSIGN(row.times, measure_times(forced, change.names, pass_ms));
    }
    for (std::size_t p = 0; p < passes_.size(); ++p) {
      if (take_bytes(passes_[p], change.memory)) passes_[p].times = times_of(pass_ms[p]);
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
  Without base_;
  std::vector<LeftOutRow> passes_;
  std::unique_ptr<Frame> without_;  // null: nothing is timed
};

}  // namespace

std::string bytes_text(std::uint64_t bytes) {
  if (bytes < std::uint64_t{10} * 1024) return fmt::format("{} B", bytes);
  if (bytes < std::uint64_t{10} * 1024 * 1024) return fmt::format("{:.1f} KiB", static_cast<double>(bytes) / 1024);
  return fmt::format("{:.1f} MiB", static_cast<double>(bytes) / (1024 * 1024));
}

LeftOutPlan plan_left_out(const MemoryShape& shape) {
  const Without base(shape);
  LeftOutPlan plan{pass_rows(shape.needs, shape.settings)};
  const std::size_t passes = plan.rows.size();
  for (const LeftOutRow& row : plan.rows) plan.code_bytes += row.code_bytes;
  for (const PassMemory& code : code_sizes()) plan.used_code_bytes += code.bytes;
  plan.used_code_bytes -= plan.code_bytes;
  for (const fixtures::Feature* feature : missing_features(shape.needs)) {
    Without::Change change = base.with(*feature);
    for (std::size_t p = 0; change.row.on_gpu && p < passes; ++p) (void)take_bytes(plan.rows[p], change.memory);
    plan.rows.push_back(std::move(change.row));
  }
  return plan;
}

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
