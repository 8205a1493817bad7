// The picture of the mirrored camera, for floors that mirror.
//
// The camera and its axes are mirrored in the plane of the floors. Each ray of its picture then is what one flat mirror
// makes of the ray of the same pixel of the camera's own picture, and goes on where that one meets the floor. The
// passes of a view draw that picture with the tables of the frame, where rays begin on the floor (lib/mirror.glsl), at
// a fraction of the size. mirrordown.comp makes a pyramid of it, with weights for what the camera's own picture shows.
// Error and cost: docs/decisions/0149.
//
// The passes of a rig (PassEntry::before_views) are recorded once, before; the rows of beams, which are relative to the
// camera, are brought to the camera afterwards (eyes.comp).
//
// Left out of what is mirrored: light of displays, panes and lasers in the air, strips, smooth edges.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "render/image.h"
#include "render/pass.h"
#include "render/plan.h"

namespace footlight::render {

struct MirrorShape {
  std::vector<glm::ivec2> levels;  // their sizes; the first is that of the picture
  int width = 0;                   // of the image that has them all (lib/mirror_levels.glsl)
  int height = 0;
  [[nodiscard]] std::uint64_t bytes() const;  // of the image
};
[[nodiscard]] MirrorShape mirror_shape(const FrameSettings& settings);
[[nodiscard]] Result<vk::Image> make_mirror_image(vk::Device& device, const MirrorShape& shape);
// Settings of the mirrored camera's picture.
[[nodiscard]] FrameSettings mirror_settings(const FrameSettings& settings);
// GPU memory of all that a frame has for it, without the rig's table.
[[nodiscard]] std::uint64_t mirror_bytes(const MemoryShape& shape);
[[nodiscard]] std::vector<GlossRow> gloss_rows(const fixtures::Rig& rig);
[[nodiscard]] View mirrored(const View& view, double plane_m);

class Mirror {
 public:
  // own: of the camera's own picture. passes: those of the frame. Both outlive it.
  [[nodiscard]] static Result<std::unique_ptr<Mirror>> create(vk::Device& device, Resources& own,
                                                              const fixtures::Needs& needs,
                                                              const FrameSettings& settings, const PassList& passes);

  [[nodiscard]] const FrameSettings& settings() const { return settings_; }
  [[nodiscard]] const PictureImages& picture() const { return resources_.picture; }
  [[nodiscard]] std::uint64_t bytes() const;

  // The passes of the view. The parameters of the frame are those of the mirrored camera.
  void record(VkCommandBuffer commands);
  // The pyramid, when the camera's own picture has its surfaces. The parameters of the frame are those of the camera.
  void record_levels(VkCommandBuffer commands);
  // Brings the rows of beams to the camera, whose parameters the frame has by now. way_m: from the mirrored camera.
  void record_eyes(VkCommandBuffer commands, const glm::dvec3& way_m);

 private:
  explicit Mirror(RigTables& rig) : resources_{.rig = rig} {}
  Status make(vk::Device& device, Resources& own, const fixtures::Needs& needs, const FrameSettings& settings,
              const PassList& passes);

  void record_down(VkCommandBuffer commands, std::int32_t stage);

  struct Steps;
  Resources resources_;
  FrameSettings settings_;
  std::vector<std::unique_ptr<Pass>> passes_;
  std::shared_ptr<Steps> steps_;
  MirrorShape shape_;
};

// Where the floors of a rig that mirror are.
class MirrorPlane {
 public:
  MirrorPlane() = default;
  explicit MirrorPlane(const fixtures::Rig& rig);
  [[nodiscard]] double height_m() const { return height_m_; }
  // False where the camera is not above it, or no floor can be in its picture. aspect: width over height.
  [[nodiscard]] bool is_seen(const View& view, double aspect) const;

 private:
  double height_m_ = 0;
  std::vector<std::vector<glm::dvec3>> corners_m_;  // of each floor
};

}  // namespace footlight::render
