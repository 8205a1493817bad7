// A window with a picture in it and Dear ImGui over that: GLFW, a Vulkan swapchain, one frame in flight.
//
//   FL_ASSIGN(auto window, Window::open("title", 1280, 720));
//   FL_ASSIGN(auto device, vk::Device::create({.instance_extensions = window->instance_extensions(),
//                                              .swapchain = true}));
//   FL_TRY(window->attach(*device));
//   while (!window->wants_close()) {
//     window->poll();
//     window->begin_ui();  ... ImGui ...  window->end_ui();
//     FL_TRY(window->wait_gpu());
//     FL_TRY(window->show(picture, [&](VkCommandBuffer commands) { frame->record(commands, view, ev); }));
//   }
//
// One frame in flight, because a frame's states and levels are the next one's start: a second one would wait for the
// first anyway, and one keeps the light a frame nearer to the desk. Waits for the screen (FIFO), never longer than a
// second.
//
// Knows nothing of rigs. Threads: the main thread only, as GLFW demands. The device must outlive attach()ed windows,
// until they are detached.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "render/image.h"
#include "render/vk/device.h"
#include "render/vk/memory.h"

struct GLFWwindow;

namespace footlight::tools {

struct PixelRect {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

// What show() puts on the screen: an image in VK_IMAGE_LAYOUT_GENERAL, stretched over a part of the window.
struct WindowPicture {
  VkImage image = VK_NULL_HANDLE;
  int width = 0;
  int height = 0;
  PixelRect place;  // cut to the window; the rest, or all of it without an image, is black
};

class Window {
 public:
  // kUnsupported where there is no display; the message says what does without one.
  [[nodiscard]] static Result<std::unique_ptr<Window>> open(const std::string& title, int width, int height);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  [[nodiscard]] const std::vector<std::string>& instance_extensions() const { return instance_extensions_; }
  // kUnsupported where the device cannot show pictures in this window.
  Status attach(render::vk::Device& device);
  // Lets go of the device, so that another one can be attached: after a loss. What ImGui remembered is gone.
  void detach();

  void set_title(const std::string& title);
  void hide();

  // Handles events. Waits up to wait_s for one; while the window is minimised, up to 100 ms.
  void poll(double wait_s = 0);
  [[nodiscard]] bool wants_close() const;
  // The keys that the last poll() saw going down, or repeating while held, in order: GLFW_KEY_... ImGui's own list
  // would miss a key that goes down and up within one slow frame.
  struct Key {
    int code = 0;
    bool repeat = false;
  };
  [[nodiscard]] const std::vector<Key>& keys() const { return keys_; }
  // As of the last poll(): nobody can see the window.
  [[nodiscard]] bool minimised() const { return minimised_; }
  // Pixels.
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  // Pixels a unit of ImGui, and how large things should be drawn for this screen.
  [[nodiscard]] float pixels_per_unit() const;
  [[nodiscard]] float ui_scale() const { return ui_scale_; }

  void begin_ui();
  void end_ui();

  // Returns when the GPU is done with the last show().
  Status wait_gpu();
  // Records `record`, then the picture, then what ImGui drew; submits and presents. Where the window has just changed
  // its size nothing is recorded and the answer is false.
  [[nodiscard]] Result<bool> show(const WindowPicture& picture, const std::function<void(VkCommandBuffer)>& record);

  // The next show() keeps a copy of the window for read_shot().
  void keep_shot() { shot_wanted_ = true; }
  // Waits for the GPU. Empty where the window system does not let its images be read.
  [[nodiscard]] Result<render::ScreenImage> read_shot();

 private:
  Window() = default;
  Status create_swapchain();
  void destroy_swapchain();
  Status create_render_pass();
  Status start_ui();
  void record_all(VkCommandBuffer commands, std::uint32_t index, const WindowPicture& picture);
  static void on_key(GLFWwindow* window, int key, int scancode, int action, int mods);
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
  std::vector<Key> keys_;
  float ui_scale_ = 1;
  bool ui_started_ = false;

  render::vk::Device* device_ = nullptr;
  VkSurfaceKHR surface_ = VK_NULL_HANDLE;
  VkSurfaceFormatKHR format_{};
  VkSwapchainKHR swapchain_ = VK_NULL_HANDLE;
  std::vector<Target> targets_;
  std::uint32_t image_count_min_ = 2;
  VkExtent2D extent_{};
  bool stale_ = true;      // the swapchain does not fit the window any more
  bool readable_ = false;  // its images can be copied from
  VkRenderPass render_pass_ = VK_NULL_HANDLE;
  VkDescriptorPool descriptors_ = VK_NULL_HANDLE;
  VkCommandPool pool_ = VK_NULL_HANDLE;  // its own, since a frame may be made on another thread
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkSemaphore acquired_ = VK_NULL_HANDLE;
  VkFence done_ = VK_NULL_HANDLE;

  bool shot_wanted_ = false;
  render::vk::Buffer shot_;
  VkExtent2D shot_extent_{};
};

}  // namespace footlight::tools
