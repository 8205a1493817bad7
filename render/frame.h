// The frame: from raw levels to a picture, headless and windowed alike.
//
//   levels, dt -> step -> gather -> gobos -> bodies -> tiles -> surfaces -> beams -> edges -> lenses -> glare
//     -> tonemap -> screen
//
// Per frame only the levels, the camera and the time step are uploaded. Passes that the rig does not need do not exist.
// Three owners hold what a frame is made of: RigTables (once a rig), PictureImages (once a size), and the pipelines of
// the device (once a combination of constants). change() replaces only what follows from the other settings.
// One thread. The device must outlive the frame.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fixtures/model/rig.h"
#include "fixtures/simulate/walker.h"
#include "render/display_films.h"
#include "render/frame_state.h"
#include "render/haze.h"
#include "render/image.h"
#include "render/mirror.h"
#include "render/pass.h"
#include "render/plan.h"
#include "render/resources.h"
#include "render/screen_lights.h"
#include "render/settings.h"
#include "render/vk/device.h"

namespace footlight::fixtures {
class MachineAir;   // fixtures/simulate/machines.h
class MediaPlayer;  // fixtures/media/media_player.h
}

namespace footlight::render {

// Steps that wait for the GPU, at most about: above either, steps_are_due().
inline constexpr std::size_t kStepsHeldMax = 512;
inline constexpr std::size_t kStepBytesHeldMax = std::size_t{64} << 20;

// What a picture draws of the bodies of fixtures.
struct BodyCounts {
  std::uint64_t bodies = 0;            // of the rig
  std::uint64_t drawn = 0;
  std::uint64_t triangles = 0;         // of the whole models of all bodies
  std::uint64_t drawn_triangles = 0;   // of the levels that are drawn
  std::uint64_t object_triangles = 0;  // of the scene, all drawn
};

// What the last picture computed for the light of displays (render/shaders/displaynodes.comp).
struct DisplayWork {
  std::array<std::uint32_t, FL_DISPLAY_RECORD_LEVELS> records{};  // squares of 64, 32, 16 and 8 pixels a side
  std::uint64_t pixels = 0;                                       // computed one by one
  std::uint64_t surface_pixels = 0;                               // likewise, their light on surfaces alone
};

struct PassTime {
  std::string name;
  double gpu_ms = 0;
};

// FrameSettings::edge_samples where nothing is chosen: lavapipe takes 0.42 s of CPU time for 16 samples of the demo's
// edges at 640 x 360, and 0.28 s for 4 (docs/decisions/0172).
[[nodiscard]] inline std::uint32_t suited_edge_samples(const vk::Device& device) {
  return device.is_software() ? 4 : 16;
}
// FrameSettings::shadow_map_px of a window where nothing is chosen: a CPU draws the demo in three quarters of the time
// with maps (docs/numerics.md).
[[nodiscard]] inline std::uint32_t window_map_px(const vk::Device& device) {
  return device.is_software() ? kMapUsualPx : kShadowsSuited;
}

class Frame {
 public:
  // first: settings of the first pictures, if they have less than `settings`, which change() is to bring; null: the
  // same.
  [[nodiscard]] static Result<std::unique_ptr<Frame>> create(vk::Device& device, const fixtures::Rig& rig,
                                                             const fixtures::CompiledRig& compiled,
                                                             const FrameSettings& settings,
                                                             const PassList& passes = product_passes(),
                                                             const FrameSettings* first = nullptr);
  // A frame of another size for pictures of the same rig: it has the tables of `owner`, which must outlive it, also the
  // states of heads. So its pictures show where the heads of the owner are. It makes no steps. GPU memory: that of its
  // images.
  [[nodiscard]] static Result<std::unique_ptr<Frame>> create_beside(Frame& owner, const FrameSettings& settings);
  // Before record() of a frame beside another one: takes the time and the air of its owner.
  void follow(const Frame& owner);
  ~Frame();
  // Takes other settings from the next record() on. Heads keep their states; models and images are not read again. The
  // images of another size replace the old ones, which are freed first. A pipeline is compiled the first time that its
  // constants are needed on this device. The commands of the record() before must be finished.
  // kBadInput, with nothing changed, where the settings are wrong, or where they have bodies that create() was to leave
  // out. After any other error only change() may follow.
  Status change(const FrameSettings& requested);
  // Begins to compile what change() to these settings needs, beside the pictures: it is quick once
  // Device::pipelines() have finished(). Until then no other thread may use these.
  void compile_ahead(const FrameSettings& requested);
  Frame(const Frame&) = delete;
  Frame& operator=(const Frame&) = delete;

  // Notes one step of dt_ns >= 0 with these levels held (universes x 512 bytes, as CompiledRig::universes orders them).
  // Steps are carried out in order by the next record(); any number of them may come before a picture. The picture
  // shows the mean light over the steps since the last one that said new_exposure.
  void step(std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure = true);

  // Records the pending steps and the whole picture; the caller submits. Afterwards resources().screen holds the
  // picture in VK_IMAGE_LAYOUT_GENERAL. Times can be read once the GPU is done with these commands.
  // The commands of the record() before must be finished: both use the same memory.
  // exposure_ev: with FrameSettings::auto_exposure that of pictures before the first light.
  // adapts: the automatic exposure follows this picture. Else it stays, and its time counts for the next one that does:
  // for another view of the stage.
  void record(VkCommandBuffer commands, const View& view, double exposure_ev, bool adapts = true);

  // The automatic exposure follows the light for dt_ns >= 0 before the next record(). Whatever the number of pictures,
  // it comes as near in the same time. The first picture with light in it has the exposure that suits it.
  void adapt_for(std::int64_t dt_ns) { adapt_ns_ += dt_ns; }

  // What haze and fog machines have brought into the air by the last step(); null in a rig without any. A picture has
  // the air of its end: its haze differs from the mean over an exposure by what comes in half of that.
  [[nodiscard]] const fixtures::MachineAir* machine_air() const { return machines_.get(); }
  // What media servers play by the last step(); null in a rig in which nothing shows one. Whoever shows it gives the
  // pixels by show_pixels().
  [[nodiscard]] const fixtures::MediaPlayer* media() const { return media_.get(); }
  // Goes on with air without what machines have made, with clouds of haze and media servers as at the start, and with
  // reflections that the next picture makes whole: its time is another one.
  void forget_air();
  // The air after an hour of these levels.
  void settle_machine_air(std::span<const std::uint8_t> levels);

  // Where fixtures and air are now, and going back there: to the bit. Both carry pending steps out first. The picture
  // after load_state() makes all reflections, whatever FrameSettings::probe_texels is. `state` is of
  // a frame of the same rig, of this device or another of the same kind.
  [[nodiscard]] Result<FrameState> save_state();
  Status load_state(const FrameState& state);

  // Work light from the next picture on, lx on a face that looks up and at the camera, on top of the rig's ambient
  // light. At first there is none.
  void set_work_light_lx(double work_light_lx) { work_light_lx_ = work_light_lx; }
  // The plumes of machines, now: those of its own machines, or what set_puffs() got last.
  [[nodiscard]] std::vector<fixtures::PlumePuff> puffs() const;
  // Replaces them from the next picture on; none: its own again. Does nothing in a rig without plumes.
  // Those beyond FL_PUFFS_MAX are left out.
  void set_puffs(std::vector<fixtures::PlumePuff> puffs) { puffs_ = std::move(puffs); }
  // Scattering of the room's own haze from the next picture on, in 1/m; finite, 0 or more. Changes no pass. Does
  // nothing in a rig that has no haze.
  void set_haze_per_m(double scattering_per_m) {
    if (needs_.haze) haze_.scattering_per_m = scattering_per_m;
  }

  // The pixels of what shows a video or a media server (fixtures::shown_at() of the rig), columns x rows of them, from
  // the next record() on. Until the first ones it is dark. Ignored if it shows something else.
  void show_pixels(std::size_t display, const std::shared_ptr<const fixtures::PaneImage>& pixels) {
    films_.show(display, pixels);
  }

  // Headless: record, submit, wait.
  Status draw(const View& view, double exposure_ev);
  // Carries the pending steps out without making a picture: for long replays between pictures.
  Status run_steps();
  [[nodiscard]] std::size_t pending_steps() const { return pending_count_; }
  // Of their levels. Levels of universes that only pixels of displays read are held once, those of the others once a
  // step; without a step pass all are held once.
  [[nodiscard]] std::size_t pending_bytes() const { return pending_bytes_ + newest_.size(); }
  // Whether so much is held that run_steps() is better than more steps.
  [[nodiscard]] bool steps_are_due() const {
    return pending_count_ >= kStepsHeldMax || pending_bytes_ >= kStepBytesHeldMax;
  }

  // distances_m, if not null, receives how far from the camera is what each pixel shows; FL_FAR_M: nothing.
  [[nodiscard]] Result<RadianceImage> read_radiance(std::vector<float>* distances_m = nullptr);
  // The light as the camera's lens leaves it: of the screen's pixels, with glare. What the tone map gets.
  [[nodiscard]] Result<RadianceImage> read_seen();
  [[nodiscard]] Result<ScreenImage> read_screen();
  // Exposure of the last recorded picture: that of record(), or the automatic one.
  [[nodiscard]] Result<double> read_exposure_ev();
  [[nodiscard]] Result<CountsRow> read_counts();
  [[nodiscard]] Result<DisplayWork> read_display_work();  // without displays: none
  [[nodiscard]] Result<std::vector<fixtures::f32::Walker::HeadState>> read_states();
  [[nodiscard]] Result<std::vector<fixtures::f32::Motor>> read_motors();
  [[nodiscard]] Result<std::vector<fixtures::f32::Spin>> read_spins();
  [[nodiscard]] Result<std::vector<fixtures::f32::Shutter>> read_shutters();
  [[nodiscard]] Result<std::vector<fixtures::f32::Walker::OpticsState>> read_optics();
  // Of each kind of lamp: read_tungsten_states(), read_led_states(), read_discharge_states().
#define FL_LAMP_READ(number, Kind, need, State, per_head) \
  [[nodiscard]] Result<std::vector<fixtures::f32::State>> read_##need##_states();
  FL_LAMPS(FL_LAMP_READ)
#undef FL_LAMP_READ
  [[nodiscard]] Result<std::vector<fixtures::f32::Slew>> read_dowsers();
  [[nodiscard]] Result<std::vector<fixtures::f32::Smooth>> read_smooths();
  [[nodiscard]] Result<std::vector<BeamRow>> read_beams();         // the live ones
  [[nodiscard]] Result<std::vector<CoarseRow>> read_supertiles();  // row by row; empty without tile classes
  [[nodiscard]] Result<GatesHead> read_gates();                    // of the last recorded picture; 0 without gates
  [[nodiscard]] Result<BodyCounts> read_bodies();                  // of the last recorded picture
  // GPU time of each pass of the last recorded picture, which must be finished. Before
  // them "levels", the way of the first step's levels to the GPU, where there was one; all steps count into "step".
  // Empty on a device without time stamps.
  [[nodiscard]] Result<std::vector<PassTime>> read_times();

  [[nodiscard]] const std::vector<PassPlan>& plan() const { return plan_; }
  [[nodiscard]] const FrameSettings& settings() const { return settings_; }
  [[nodiscard]] Resources& resources() { return resources_; }
  [[nodiscard]] const DisplayFilms& films() const { return films_; }
  // Memory of all buffers and images, including those of passes and those of the host that films are copied to.
  [[nodiscard]] std::uint64_t bytes() const;

 private:
  struct PendingStep {
    std::vector<std::uint8_t> levels;  // of stepped_, one after the other; of the last step: empty, they are newest_
    std::int64_t dt_ns;
    bool new_exposure;
  };
  // shared: the tables of another frame; null: its own ones.
  Frame(vk::Device& device, const PassList& passes, RigTables* shared = nullptr);
  Status check_settings(const FrameSettings& settings) const;
  [[nodiscard]] FrameSettings suited(FrameSettings settings) const;
  void begin_pipelines(const FrameSettings& settings, Resources& resources);
  void compile_beside_tables(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled,
                             const FrameSettings& requested);
  [[nodiscard]] bool draws(const PassEntry& entry) const;
  void hold_newest();
  void upload_levels(VkCommandBuffer commands, const PendingStep& pending);
  void upload_newest(VkCommandBuffer commands);
  void record_steps(VkCommandBuffer commands, bool timed);
  void record_levels(VkCommandBuffer commands);
  void record_pixels(VkCommandBuffer commands);
  void upload_haze(VkCommandBuffer commands, const View& view, const PlumeField& plumes);
  // mirror: `view` is that of its camera; null: of the frame's own.
  void upload_params(VkCommandBuffer commands, const View& view, double exposure_ev, const Mirror* mirror = nullptr);
  void record_passes(VkCommandBuffer commands, bool before_views);
  void mark(VkCommandBuffer commands, std::string_view ended);
  template <class Row>
  [[nodiscard]] Result<std::vector<Row>> read_rows(const vk::Buffer& buffer, std::uint32_t count);
  [[nodiscard]] Status read_buffer(const vk::Buffer& buffer, void* out, std::size_t bytes);
  [[nodiscard]] std::vector<const vk::Buffer*> state_buffers() const;
  void clear_radiance(VkCommandBuffer commands);
  [[nodiscard]] Status read_image(const vk::Image& image, int width, int height, void* out, std::size_t bytes);

  vk::Device& device_;
  FrameSettings settings_;
  fixtures::Needs needs_;  // of the rig, whatever the settings
  fixtures::Haze haze_;    // the room's own
  std::vector<fixtures::PlumePuff> puffs_;  // instead of those of its machines
  double ambient_lx_ = 0;
  RigTables tables_;  // empty if they are shared
  Resources resources_;
  MirrorPlane mirror_plane_;
  std::unique_ptr<Mirror> mirror_;  // null: nothing mirrors
  Frame* owner_ = nullptr;  // of a frame beside another one
  DisplayFilms films_;
  ScreenLights screens_;
  PassList entries_;  // those that the rig and the settings need are in passes_
  std::vector<PassPlan> plan_;
  std::vector<std::unique_ptr<Pass>> passes_;  // one a plan entry
  std::vector<bool> before_views_;             // PassEntry::before_views, likewise
  bool is_mirrored_ = false;                   // by record(): a floor that mirrors is in the picture
  std::vector<PendingStep> pending_;           // empty without a step pass
  std::size_t pending_count_ = 0;
  std::size_t pending_bytes_ = 0;
  std::vector<std::uint8_t> newest_;  // levels of the last pending step, of all universes
  struct LevelRange {
    VkDeviceSize first;
    VkDeviceSize size;
  };
  std::vector<LevelRange> stepped_;  // of the levels, bytes: universes that more than pixels of displays read
  std::unique_ptr<fixtures::MachineAir> machines_;  // may be null
  std::unique_ptr<fixtures::MediaPlayer> media_;    // may be null
  double work_light_lx_ = 0;
  std::int64_t adapt_ns_ = 0;    // since the last record() that adapted
  bool adapts_ = true;           // the last record()
  double exposure_ev_ = 0;       // of the last record()
  std::int64_t time_ns_ = 0;     // of all steps: clouds of haze drift by it
  glm::dvec3 haze_center_m_{0};  // of a sphere that all light in the air lies in
  double haze_radius_m_ = 0;
  bool has_step_ = false;
  bool has_solids_ = false;
  bool has_fine_ = false;  // beams are taken together for tiles
  double range_m_ = 0;
  vk::Buffer state_bytes_;  // on their way to or from the GPU; made when first needed
  VkQueryPool times_ = VK_NULL_HANDLE;
  std::vector<std::string_view> timed_;  // what each time stamp of the last record() is the end of
};

}  // namespace footlight::render
