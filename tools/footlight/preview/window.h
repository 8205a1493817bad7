// A window with a picture in it and Dear ImGui over that: GLFW, a Vulkan swapchain, one frame in flight.
//
//   FL_ASSIGN(auto window, Window::open("title", 1280, 720));
//   FL_ASSIGN(auto device, vk::Device::create({.instance_extensions = window->instance_extensions(),
//                                              .swapchain = true}));
//   FL_TRY(window->attach(*device));
//   while (!window->wants_close()) {
//     window->poll();
//     if (there is a new picture) FL_TRY(window->set_picture(0, picture));
//     window->begin_ui();  ... ImGui ...  window->end_ui();
//     FL_TRY(window->show({&place, 1}));
//   }
//
// The picture comes through memory of the host, so that the device that draws it can be another one, which may be busy
// (decision 0150). One frame in flight: the GPU only copies a picture and draws ImGui's triangles. Waits for the screen
// (FIFO), at most one second.
//
// Independent of rigs. Threads: the main thread only, as GLFW requires. The device must outlive attach()ed windows.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "render/image.h"
#include "render/vk/device.h"
#include "render/vk/memory.h"
#include "tools/footlight/preview/key_presses.h"
#include "tools/footlight/preview/mouse_queue.h"
#include "tools/footlight/preview/ui/keys.h"
#include "tools/footlight/preview/ui/picture_shelf.h"
#include "tools/footlight/preview/ui/stage_views.h"
#include "tools/footlight/preview/uploaded_image.h"
#include "tools/footlight/preview/window_settings.h"
#include "tools/footlight/preview/window_ui.h"

struct GLFWwindow;

namespace footlight::tools {

class Window {
 public:
  // kUnsupported if there is no display; the message names a command that works without one.
  [[nodiscard]] static Result<std::unique_ptr<Window>> open(const std::string& title, int width, int height);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  [[nodiscard]] const std::vector<std::string>& instance_extensions() const { return instance_extensions_; }
  // kUnsupported if the device cannot show pictures in this window.
  Status attach(render::vk::Device& device);
  // Lets go of the device, so that another one can be attached: after a loss. What ImGui remembered is gone; the last
  // picture is shown again.
  void detach();

  void set_title(const std::string& title);
  void hide();
  // On the screen that most of the window is on, and back to where it was.
  void toggle_full_screen();

  // Handles events. Waits up to wait_s for one; while the window is minimised, up to 100 ms.
  void poll(double wait_s = 0);
  // Handles events for that long. Its keys are among those of the next poll().
  void pause(double pause_s);
  [[nodiscard]] bool wants_close() const;
  // The user is asked first: wants_close() is false until the next time.
  void keep_open();
  // The keys that went down during the last poll(), or repeated while held, in order. ImGui's own list misses a key
  // that goes down and up within one slow frame.
  [[nodiscard]] const std::vector<KeyPress>& keys() const { return keys_.presses(); }
  // The key of the dead man's switch is held, as of the last poll() and the keyboard itself; not in a window that is
  // iconified or has not the keyboard.
  [[nodiscard]] bool holds_live_key();
  // Paths of files that were dropped on the window since the last call, in order.
  [[nodiscard]] std::vector<std::string> take_drops() { return std::exchange(drops_, {}); }
  // As of the last poll(): true if the window is not visible.
  [[nodiscard]] bool minimised() const { return minimised_; }
  // Pixels.
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  // Pixels per unit of ImGui, and the scale of the user interface for this screen.
  [[nodiscard]] float pixels_per_unit() const { return pixels_per_unit_; }
  [[nodiscard]] float ui_scale() const { return ui_scale_ * user_scale_; }
  // How large the user interface is beside what suits the screen, and its theme. Between two pictures. The next
  // set_pictures() makes the glyphs for it.
  void set_ui_look(float user_scale, UiTheme theme);
  // Pictures a second of the fastest screen; 60 if that is unknown.
  [[nodiscard]] static double refresh_hz();

  // ImGui's mouse is where it was when a button went down or up; a picture gets at most one of these.
  void begin_ui();
  void end_ui();

  // The pictures that panels draw, which have a place beside ImGui's glyphs: its renderer knows one image only. Before
  // begin_ui(): tells the shelf where that is, and copies it where it has changed.
  Status set_pictures(PictureShelf& pictures);
  // Returns when the GPU is done with the last show().
  Status wait_gpu();
  // What the next show() shows in its place of this number; copies it. Until the first one there is none.
  Status set_picture(int view, const HostPicture& picture);
  // Frees the pictures from this number on.
  Status drop_pictures(int from_view);
  // The pictures, each stretched over its place, which is clipped to the window, and ImGui's draw data over them; the
  // rest is black. At most kViewsMax places. Submits and presents. If the window has just changed its size, nothing is
  // shown and the result is kLater.
  // If all of it is what the window shows already, nothing needs to be done: kSame.
  enum class Shown { kLater, kSame, kNew };
  [[nodiscard]] Result<Shown> show(std::span<const PixelRect> places);

  // The next show() keeps a copy of the window for read_shot().
  void keep_shot() { shot_wanted_ = true; }
  // Waits for the GPU. Empty if the window system does not allow reading its images.
  [[nodiscard]] Result<render::ScreenImage> read_shot();

 private:
  Window() = default;
  Status create_swapchain();
  void destroy_swapchain();
  Status create_render_pass();
  Status start_ui();
  void add_fonts();
  Status start_renderer();
  Status remake_fonts();
  Status present(std::uint32_t index);
  void record_pictures(VkCommandBuffer commands, VkImage target);
  void record_picture(VkCommandBuffer commands, VkImage target, const UploadedImage& picture,
                      const PixelRect& place);
  void record_shelf(VkCommandBuffer commands);
  void record_ui(VkCommandBuffer commands, const VkFramebuffer& target);
  static void on_key(GLFWwindow* window, int key, int scancode, int action, int mods);
  static void on_character(GLFWwindow* window, unsigned int character);
  static void on_cursor(GLFWwindow* window, double x, double y);
  static void on_button(GLFWwindow* window, int button, int action, int mods);
  static void on_refresh(GLFWwindow* window);
  static void on_size(GLFWwindow* window, int width, int height);
  static void on_iconify(GLFWwindow* window, int iconified);
  static void on_focus(GLFWwindow* window, int focused);
  void read_sizes();
  static void on_drop(GLFWwindow* window, int count, const char** paths);
  [[nodiscard]] PixelRect rect() const;
  void record_shot(VkCommandBuffer commands, VkImage image);

  struct Target {
    VkImage image = VK_NULL_HANDLE;
    VkImageView view = VK_NULL_HANDLE;
    VkFramebuffer framebuffer = VK_NULL_HANDLE;
    VkSemaphore drawn = VK_NULL_HANDLE;  // presenting waits for it
  };

  GLFWwindow* window_ = nullptr;
  std::vector<std::string> instance_extensions_;
  int width_ = 0;
  int height_ = 0;
  bool minimised_ = false;
  bool resized_ = true;  // the sizes above are to be read again
  float pixels_per_unit_ = 1;
  KeyPresses keys_;
  bool keeps_keys_ = false;  // those since the last poll()
  KeyTaps taps_;
  HeldKey live_key_{kHoldKey};
  std::vector<std::string> drops_;
  MouseQueue mouse_;
  PixelRect before_full_;  // where the window was before it became full screen
  float ui_scale_ = 1;     // of the screen
  float user_scale_ = 1;   // beside that
  float font_scale_ = 1;   // ui_scale() when the font was made
  bool has_font_file_ = false;  // else ImGui's own font is scaled
  bool fonts_are_old_ = false;  // they are made anew before the next frame
  UiTheme theme_ = UiTheme::kDark;
  bool ui_started_ = false;

  render::vk::Device* device_ = nullptr;
  VkSurfaceKHR surface_ = VK_NULL_HANDLE;
  VkSurfaceFormatKHR format_{};
  VkSwapchainKHR swapchain_ = VK_NULL_HANDLE;
  std::vector<Target> targets_;
  std::uint32_t image_count_min_ = 2;
  VkExtent2D extent_{};
  bool stale_ = true;      // the swapchain no longer fits the window
  bool readable_ = false;  // its images can be copied
  VkRenderPass render_pass_ = VK_NULL_HANDLE;
  VkDescriptorPool descriptors_ = VK_NULL_HANDLE;
  VkCommandPool pool_ = VK_NULL_HANDLE;  // separate, since a frame may be made on another thread
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkSemaphore acquired_ = VK_NULL_HANDLE;
  VkFence done_ = VK_NULL_HANDLE;

  std::array<UploadedImage, kViewsMax> pictures_;
  struct Kept {
    std::vector<std::uint8_t> rgba;
    int width = 0;
    int height = 0;
  };
  std::array<Kept, kViewsMax> kept_;  // the last pictures of a device that was let go
  int shelf_rect_ = -1;               // of set_pictures(), in ImGui's atlas of glyphs
  std::uint64_t shelf_revision_ = 0;  // that the atlas has, or shelf_bytes_
  bool shelf_fresh_ = false;          // shelf_bytes_ are not yet in the atlas
  render::vk::Buffer shelf_bytes_;    // made with the first picture
  ShownUi shown_;
  std::vector<PixelRect> places_;  // of the last show()
  bool damaged_ = true;  // the window shows something else than the last show()

  bool shot_wanted_ = false;
  render::vk::Buffer shot_;
  VkExtent2D shot_extent_{};
};

}  // namespace footlight::tools
