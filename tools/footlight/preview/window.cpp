#include "tools/footlight/preview/window.h"

#include <algorithm>
#include <array>
#include <utility>

#include <unistd.h>

#include <vulkan/vulkan.h>

#include <GLFW/glfw3.h>

#include <imgui/backends/imgui_impl_glfw.h>
#include <imgui/backends/imgui_impl_vulkan.h>
#include <imgui/imgui.h>

#include "tools/footlight/preview/display_loss.h"
#include "tools/footlight/preview/key_state.h"
#include "tools/footlight/preview/ui/ui_theme.h"

namespace footlight::tools {
namespace {

namespace vk = render::vk;

constexpr double kMinimisedWaitS = 0.1;
constexpr float kFontPx = 14;
// From Debian's fonts-dejavu-core, which every desktop has; ImGui's built-in font if it is missing.
constexpr const char* kFontPath = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";

std::string last_glfw_error() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text != nullptr ? text : "unknown error";
}

}  // namespace

Result<std::unique_ptr<Window>> Window::open(const std::string& title, int width, int height) {
  if (glfwInit() != GLFW_TRUE) {
    return fail(ErrorCode::kUnsupported,
                "no window: {}; start it in a desktop session, or use 'footlight render', which makes pictures and "
                "videos without a display",
                last_glfw_error());
  }
  std::unique_ptr<Window> window(new Window());
  note_display_loss();
  if (glfwVulkanSupported() != GLFW_TRUE) {
    return fail(ErrorCode::kUnsupported,
                "no window: Vulkan cannot draw into one here ({}); use 'footlight render', which needs no display",
                last_glfw_error());
  }
  std::uint32_t count = 0;
  const char** extensions = glfwGetRequiredInstanceExtensions(&count);
  if (extensions == nullptr) {
    return fail(ErrorCode::kUnsupported,
                "no window: Vulkan does not support this display ({}); use 'footlight render', which needs no display",
                last_glfw_error());
  }
  window->instance_extensions_.assign(extensions, extensions + count);
  glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
  window->window_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
  if (window->window_ == nullptr) {
    return fail(ErrorCode::kUnsupported, "no window of {}x{}: {}; use 'footlight render', which needs no display",
                width, height, last_glfw_error());
  }
  float scale_x = 1;
  float scale_y = 1;
  glfwSetWindowUserPointer(window->window_, window.get());
  glfwSetWindowSizeCallback(window->window_, &Window::on_size);
  glfwSetFramebufferSizeCallback(window->window_, &Window::on_size);
  glfwSetWindowIconifyCallback(window->window_, &Window::on_iconify);
  glfwSetWindowFocusCallback(window->window_, &Window::on_focus);
  window->read_sizes();
  glfwGetWindowContentScale(window->window_, &scale_x, &scale_y);
  window->ui_scale_ = std::clamp(std::max(scale_x, scale_y) / window->pixels_per_unit(), 1.0f, 4.0f);
  if (window->ui_scale_ == 1 && window->pixels_per_unit() == 1) {  // the desktop states 96 dpi, or nothing
    GLFWmonitor* screen = glfwGetPrimaryMonitor();
    const GLFWvidmode* mode = screen != nullptr ? glfwGetVideoMode(screen) : nullptr;
    if (mode != nullptr) window->ui_scale_ = ui_scale_for(mode->height, window->height());
  }
  window->poll();
  return window;
}

Window::~Window() {
  detach();
  if (display_is_lost()) return;  // Xlib ends the program when requests to a lost server fill its buffer
  if (window_ != nullptr) glfwDestroyWindow(window_);
  glfwTerminate();
}

void Window::detach() {
  for (std::size_t i = 0; i < pictures_.size(); ++i) {
    if (const HostPicture last = pictures_[i].picture(); !last.rgba.empty()) {
      kept_[i] = {{last.rgba.begin(), last.rgba.end()}, last.width, last.height};
    }
  }
  if (device_ != nullptr) {
    (void)device_->wait_idle();
    if (ui_started_) {
      ImGui_ImplVulkan_Shutdown();
      if (!display_is_lost()) ImGui_ImplGlfw_Shutdown();
    }
    destroy_swapchain();
    if (swapchain_ != VK_NULL_HANDLE) vkDestroySwapchainKHR(device_->handle, swapchain_, nullptr);
    vkDestroyRenderPass(device_->handle, render_pass_, nullptr);
    vkDestroyDescriptorPool(device_->handle, descriptors_, nullptr);
    vkDestroySemaphore(device_->handle, acquired_, nullptr);
    vkDestroyFence(device_->handle, done_, nullptr);
    vkDestroyCommandPool(device_->handle, pool_, nullptr);
    if (surface_ != VK_NULL_HANDLE) vkDestroySurfaceKHR(device_->instance, surface_, nullptr);
  }
  if (ImGui::GetCurrentContext() != nullptr) ImGui::DestroyContext();
  shot_ = {};
  for (UploadedImage& picture : pictures_) picture = {};
  shelf_bytes_ = {};
  shown_.forget();
  damaged_ = true;
  mouse_.clear();
  device_ = nullptr;
  ui_started_ = false;
  stale_ = true;
  swapchain_ = VK_NULL_HANDLE;
  shelf_fresh_ = false;
  shelf_revision_ = 0;
  render_pass_ = VK_NULL_HANDLE;
  descriptors_ = VK_NULL_HANDLE;
  acquired_ = VK_NULL_HANDLE;
  done_ = VK_NULL_HANDLE;
  pool_ = VK_NULL_HANDLE;
  surface_ = VK_NULL_HANDLE;
}

Status Window::attach(vk::Device& device) {
  device_ = &device;
  if (glfwCreateWindowSurface(device.instance, window_, nullptr, &surface_) != VK_SUCCESS) {
    return fail(ErrorCode::kUnsupported, "{} cannot draw into a window: {}", device.name(), last_glfw_error());
  }
  VkBool32 can_present = VK_FALSE;
  FL_TRY(vk::check(vkGetPhysicalDeviceSurfaceSupportKHR(device.physical, device.queue_family, surface_, &can_present),
                   "vkGetPhysicalDeviceSurfaceSupportKHR"));
  if (can_present != VK_TRUE) {
    return fail(ErrorCode::kUnsupported,
                "{} cannot show pictures in this window; select another with --device ('vulkaninfo --summary' lists "
                "them), or use 'footlight render'",
                device.name());
  }

  // The tone map has already encoded sRGB, so a format without _SRGB is used.
  std::uint32_t count = 0;
  FL_TRY(vk::check(vkGetPhysicalDeviceSurfaceFormatsKHR(device.physical, surface_, &count, nullptr),
                   "vkGetPhysicalDeviceSurfaceFormatsKHR"));
  std::vector<VkSurfaceFormatKHR> formats(count);
  FL_TRY(vk::check(vkGetPhysicalDeviceSurfaceFormatsKHR(device.physical, surface_, &count, formats.data()),
                   "vkGetPhysicalDeviceSurfaceFormatsKHR"));
  const auto format = std::find_if(formats.begin(), formats.end(), [](const VkSurfaceFormatKHR& f) {
    return f.format == VK_FORMAT_B8G8R8A8_UNORM || f.format == VK_FORMAT_R8G8B8A8_UNORM;
  });
  if (format == formats.end()) {
    return fail(ErrorCode::kUnsupported, "{} offers no 8-bit RGB format for this window; use 'footlight render'",
                device.name());
  }
  format_ = *format;

  VkSemaphoreCreateInfo semaphore{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
  FL_TRY(vk::check(vkCreateSemaphore(device.handle, &semaphore, nullptr, &acquired_), "vkCreateSemaphore"));
  VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  fence.flags = VK_FENCE_CREATE_SIGNALED_BIT;
  FL_TRY(vk::check(vkCreateFence(device.handle, &fence, nullptr, &done_), "vkCreateFence"));
  VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  pool.queueFamilyIndex = device.queue_family;
  FL_TRY(vk::check(vkCreateCommandPool(device.handle, &pool, nullptr, &pool_), "vkCreateCommandPool"));
  VkCommandBufferAllocateInfo commands{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  commands.commandPool = pool_;
  commands.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  commands.commandBufferCount = 1;
  FL_TRY(vk::check(vkAllocateCommandBuffers(device.handle, &commands, &commands_), "vkAllocateCommandBuffers"));
  FL_TRY(create_render_pass());
  FL_TRY(create_swapchain());
  FL_TRY(start_ui());
  for (std::size_t i = 0; i < pictures_.size(); ++i) {
    const Kept kept = std::exchange(kept_[i], {});
    if (!kept.rgba.empty()) FL_TRY(pictures_[i].set(device, {kept.rgba, kept.width, kept.height}));
  }
  return {};
}

// Draws ImGui's data over the copied picture.
Status Window::create_render_pass() {
  VkAttachmentDescription attachment{};
  attachment.format = format_.format;
  attachment.samples = VK_SAMPLE_COUNT_1_BIT;
  attachment.loadOp = VK_ATTACHMENT_LOAD_OP_LOAD;
  attachment.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  attachment.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
  attachment.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
  attachment.initialLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
  attachment.finalLayout = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR;
  const VkAttachmentReference reference{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
  VkSubpassDescription subpass{};
  subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
  subpass.colorAttachmentCount = 1;
  subpass.pColorAttachments = &reference;
  std::array<VkSubpassDependency, 2> dependencies{};
  dependencies[0].srcSubpass = VK_SUBPASS_EXTERNAL;
  dependencies[0].dstSubpass = 0;
  dependencies[0].srcStageMask = VK_PIPELINE_STAGE_TRANSFER_BIT;
  dependencies[0].srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
  dependencies[0].dstStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
  dependencies[0].dstAccessMask = VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
  dependencies[1].srcSubpass = 0;
  dependencies[1].dstSubpass = VK_SUBPASS_EXTERNAL;
  dependencies[1].srcStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
  dependencies[1].srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
  dependencies[1].dstStageMask = VK_PIPELINE_STAGE_TRANSFER_BIT;
  dependencies[1].dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
  VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
  info.attachmentCount = 1;
  info.pAttachments = &attachment;
  info.subpassCount = 1;
  info.pSubpasses = &subpass;
  info.dependencyCount = static_cast<std::uint32_t>(dependencies.size());
  info.pDependencies = dependencies.data();
  return vk::check(vkCreateRenderPass(device_->handle, &info, nullptr, &render_pass_), "vkCreateRenderPass");
}

// Keeps the swapchain itself: the next one is made from it.
void Window::destroy_swapchain() {
  for (const Target& target : targets_) {
    vkDestroyFramebuffer(device_->handle, target.framebuffer, nullptr);
    vkDestroyImageView(device_->handle, target.view, nullptr);
    vkDestroySemaphore(device_->handle, target.drawn, nullptr);
  }
  targets_.clear();
}

// If the window has no area, the old swapchain stays and stays stale.
Status Window::create_swapchain() {
  FL_TRY(device_->wait_idle());
  VkSurfaceCapabilitiesKHR can{};
  FL_TRY(vk::check(vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device_->physical, surface_, &can),
                   "vkGetPhysicalDeviceSurfaceCapabilitiesKHR"));
  extent_ = can.currentExtent;
  if (extent_.width == UINT32_MAX) {  // the window takes the size of its images
    extent_.width = std::clamp(static_cast<std::uint32_t>(width_), can.minImageExtent.width, can.maxImageExtent.width);
    extent_.height =
        std::clamp(static_cast<std::uint32_t>(height_), can.minImageExtent.height, can.maxImageExtent.height);
  }
  stale_ = extent_.width == 0 || extent_.height == 0;
  if (stale_) return {};
  constexpr VkImageUsageFlags kNeeded = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  if ((can.supportedUsageFlags & kNeeded) != kNeeded) {
    return fail(ErrorCode::kUnsupported, "{} cannot copy pictures into this window; use 'footlight render'",
                device_->name());
  }
  readable_ = (can.supportedUsageFlags & VK_IMAGE_USAGE_TRANSFER_SRC_BIT) != 0;

  VkSwapchainCreateInfoKHR info{VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR};
  info.surface = surface_;
  image_count_min_ = std::max(2u, can.minImageCount);
  info.minImageCount = std::max(3u, image_count_min_);
  if (can.maxImageCount != 0) info.minImageCount = std::min(info.minImageCount, can.maxImageCount);
  info.imageFormat = format_.format;
  info.imageColorSpace = format_.colorSpace;
  info.imageExtent = extent_;
  info.imageArrayLayers = 1;
  info.imageUsage = kNeeded;
  if (readable_) info.imageUsage |= VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
  info.imageSharingMode = VK_SHARING_MODE_EXCLUSIVE;
  info.preTransform = can.currentTransform;
  info.compositeAlpha = (can.supportedCompositeAlpha & VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR) != 0
                            ? VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR
                            : VK_COMPOSITE_ALPHA_INHERIT_BIT_KHR;
  info.presentMode = VK_PRESENT_MODE_FIFO_KHR;  // the only one that every device supports
  info.clipped = VK_TRUE;
  info.oldSwapchain = swapchain_;
  VkSwapchainKHR fresh = VK_NULL_HANDLE;
  FL_TRY(vk::check(vkCreateSwapchainKHR(device_->handle, &info, nullptr, &fresh), "vkCreateSwapchainKHR"));
  destroy_swapchain();
  if (swapchain_ != VK_NULL_HANDLE) vkDestroySwapchainKHR(device_->handle, swapchain_, nullptr);
  swapchain_ = fresh;

  std::uint32_t count = 0;
  FL_TRY(vk::check(vkGetSwapchainImagesKHR(device_->handle, swapchain_, &count, nullptr), "vkGetSwapchainImagesKHR"));
  std::vector<VkImage> images(count);
  FL_TRY(vk::check(vkGetSwapchainImagesKHR(device_->handle, swapchain_, &count, images.data()),
                   "vkGetSwapchainImagesKHR"));
  for (VkImage image : images) {
    Target& target = targets_.emplace_back();
    target.image = image;
    VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    view.image = image;
    view.viewType = VK_IMAGE_VIEW_TYPE_2D;
    view.format = format_.format;
    view.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    FL_TRY(vk::check(vkCreateImageView(device_->handle, &view, nullptr, &target.view), "vkCreateImageView"));
    VkFramebufferCreateInfo framebuffer{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
    framebuffer.renderPass = render_pass_;
    framebuffer.attachmentCount = 1;
    framebuffer.pAttachments = &target.view;
    framebuffer.width = extent_.width;
    framebuffer.height = extent_.height;
    framebuffer.layers = 1;
    FL_TRY(vk::check(vkCreateFramebuffer(device_->handle, &framebuffer, nullptr, &target.framebuffer),
                     "vkCreateFramebuffer"));
    VkSemaphoreCreateInfo semaphore{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    FL_TRY(vk::check(vkCreateSemaphore(device_->handle, &semaphore, nullptr, &target.drawn), "vkCreateSemaphore"));
  }
  return {};
}

void Window::on_drop(GLFWwindow* window, int count, const char** paths) {
  auto& drops = static_cast<Window*>(glfwGetWindowUserPointer(window))->drops_;
  drops.insert(drops.end(), paths, paths + count);
}

void Window::set_ui_look(float user_scale, UiTheme theme) {
  user_scale_ = user_scale;
  theme_ = theme;
  if (ImGui::GetCurrentContext() == nullptr) return;  // start_ui() does it
  set_ui_style(ui_scale(), theme_);
  ImGui::GetIO().FontGlobalScale = ui_scale() / font_scale_;
  fonts_are_old_ = ui_started_ && has_font_file_ && ui_scale() != font_scale_;
}

// The glyphs for the present size of text, and room for the pictures of panels.
void Window::add_fonts() {
  ImGuiIO& io = ImGui::GetIO();
  io.Fonts->Clear();
  font_scale_ = ui_scale();
  has_font_file_ = access(kFontPath, R_OK) == 0 && io.Fonts->AddFontFromFileTTF(kFontPath, kFontPx * font_scale_,
                                                                                nullptr, ui_glyph_ranges()) != nullptr;
  if (!has_font_file_) {
    io.Fonts->AddFontDefault();
    font_scale_ = 1;
  }
  io.Fonts->TexDesiredWidth = 2 * PictureShelf::kSizePx;
  shelf_rect_ = io.Fonts->AddCustomRectRegular(PictureShelf::kSizePx, PictureShelf::kSizePx);
}

// ImGui's, with the glyphs as its image.
Status Window::start_renderer() {
  ImGui_ImplVulkan_InitInfo info{};
  info.Instance = device_->instance;
  info.PhysicalDevice = device_->physical;
  info.Device = device_->handle;
  info.QueueFamily = device_->queue_family;
  info.Queue = device_->queue;
  info.DescriptorPool = descriptors_;
  info.MinImageCount = image_count_min_;
  info.ImageCount = std::max(image_count_min_, static_cast<std::uint32_t>(targets_.size()));
  info.MSAASamples = VK_SAMPLE_COUNT_1_BIT;
  ImGui_ImplVulkan_Init(&info, render_pass_);
  ui_started_ = true;
  shelf_revision_ = 0;  // the image has no pictures yet
  FL_TRY(device_->run_once([](VkCommandBuffer commands) { ImGui_ImplVulkan_CreateFontsTexture(commands); }));
  ImGui_ImplVulkan_DestroyFontUploadObjects();
  return {};
}

// Another size of text. ImGui's renderer (1.86) makes its image once, so it starts anew.
Status Window::remake_fonts() {
  fonts_are_old_ = false;
  FL_TRY(device_->wait_idle());
  ImGui_ImplVulkan_Shutdown();
  ui_started_ = false;
  FL_TRY(vk::check(vkResetDescriptorPool(device_->handle, descriptors_, 0), "vkResetDescriptorPool"));
  add_fonts();
  set_ui_look(user_scale_, theme_);
  damaged_ = true;
  return start_renderer();
}

Status Window::start_ui() {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;                     // writes no file into the current folder
  io.ConfigWindowsMoveFromTitleBarOnly = true;  // else a drag beside a field moves the panel
  add_fonts();
  set_ui_look(user_scale_, theme_);
  // ImGui calls the callbacks that are set already.
  glfwSetKeyCallback(window_, &Window::on_key);
  glfwSetCharCallback(window_, &Window::on_character);
  glfwSetCursorPosCallback(window_, &Window::on_cursor);
  glfwSetMouseButtonCallback(window_, &Window::on_button);
  glfwSetWindowRefreshCallback(window_, &Window::on_refresh);
  glfwSetDropCallback(window_, &Window::on_drop);
  double x = 0;
  double y = 0;
  glfwGetCursorPos(window_, &x, &y);  // it may be pressed before it moves
  on_cursor(window_, x, y);
  ImGui_ImplGlfw_InitForVulkan(window_, true);

  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1};
  VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  pool.flags = VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT;
  pool.maxSets = 1;
  pool.poolSizeCount = 1;
  pool.pPoolSizes = &size;
  FL_TRY(vk::check(vkCreateDescriptorPool(device_->handle, &pool, nullptr, &descriptors_), "vkCreateDescriptorPool"));
  return start_renderer();
}

void Window::on_key(GLFWwindow* window, int key, int scancode, int action, int mods) {
  auto* self = static_cast<Window*>(glfwGetWindowUserPointer(window));
  const char* name = key != GLFW_KEY_UNKNOWN ? glfwGetKeyName(key, scancode) : nullptr;
  self->keys_.take_key(key, name, action, mods);
  self->taps_.take_key(key, action, mods);
  self->live_key_.take_key(key, action, scancode);
}

bool Window::holds_live_key() {
  if (live_key_.held()) live_key_.take_state(key_is_down(live_key_.scancode()).value_or(true));
  return live_key_.held();
}

void Window::on_character(GLFWwindow* window, unsigned int character) {
  static_cast<Window*>(glfwGetWindowUserPointer(window))->keys_.take_character(character);
}

void Window::on_cursor(GLFWwindow* window, double x, double y) {
  auto* self = static_cast<Window*>(glfwGetWindowUserPointer(window));
  self->mouse_.take_move(static_cast<float>(x), static_cast<float>(y));
}

void Window::on_button(GLFWwindow* window, int button, int action, int mods) {
  auto* self = static_cast<Window*>(glfwGetWindowUserPointer(window));
  self->mouse_.take_button(button, action == GLFW_PRESS, mods);
}

// The window system has lost what the window showed.
void Window::on_refresh(GLFWwindow* window) { static_cast<Window*>(glfwGetWindowUserPointer(window))->damaged_ = true; }

void Window::on_size(GLFWwindow* window, int, int) {
  static_cast<Window*>(glfwGetWindowUserPointer(window))->resized_ = true;
}

void Window::on_iconify(GLFWwindow* window, int) {
  auto* self = static_cast<Window*>(glfwGetWindowUserPointer(window));
  self->resized_ = true;
  self->live_key_.let_go();
}

void Window::on_focus(GLFWwindow* window, int focused) {
  static_cast<Window*>(glfwGetWindowUserPointer(window))->live_key_.take_focus(focused == GLFW_TRUE);
}

PixelRect Window::rect() const {
  PixelRect rect;
  glfwGetWindowPos(window_, &rect.x, &rect.y);
  glfwGetWindowSize(window_, &rect.width, &rect.height);
  return rect;
}

void Window::toggle_full_screen() {
  if (glfwGetWindowMonitor(window_) != nullptr) {
    glfwSetWindowMonitor(window_, nullptr, before_full_.x, before_full_.y, before_full_.width, before_full_.height,
                         GLFW_DONT_CARE);
    return;
  }
  before_full_ = rect();
  int count = 0;
  GLFWmonitor** monitors = glfwGetMonitors(&count);
  GLFWmonitor* best = nullptr;
  const GLFWvidmode* its_mode = nullptr;
  int most = -1;
  for (int i = 0; i < count; ++i) {
    const GLFWvidmode* mode = glfwGetVideoMode(monitors[i]);
    if (mode == nullptr) continue;
    int x = 0;
    int y = 0;
    glfwGetMonitorPos(monitors[i], &x, &y);
    const int across = std::min(before_full_.x + before_full_.width, x + mode->width) - std::max(before_full_.x, x);
    const int down = std::min(before_full_.y + before_full_.height, y + mode->height) - std::max(before_full_.y, y);
    const int common = std::max(across, 0) * std::max(down, 0);
    if (common <= most) continue;
    most = common;
    best = monitors[i];
    its_mode = mode;
  }
  if (best == nullptr) return;
  glfwSetWindowMonitor(window_, best, 0, 0, its_mode->width, its_mode->height, its_mode->refreshRate);
}

void Window::set_title(const std::string& title) { glfwSetWindowTitle(window_, title.c_str()); }

void Window::hide() {
  if (!display_is_lost()) glfwHideWindow(window_);
}

void Window::poll(double wait_s) {
  if (!std::exchange(keeps_keys_, false)) keys_.clear();
  if (minimised() && device_ != nullptr) wait_s = kMinimisedWaitS;
  if (wait_s > 0) {
    glfwWaitEventsTimeout(wait_s);
  } else {
    glfwPollEvents();
  }
  if (std::exchange(resized_, false)) read_sizes();
}

// Not at every turn: each of these calls waits for the X server, which may wait for a CPU.
void Window::read_sizes() {
  int units = 0;
  int unused = 0;
  int width = 0;
  int height = 0;
  glfwGetWindowSize(window_, &units, &unused);
  glfwGetFramebufferSize(window_, &width, &height);
  if (display_is_lost()) return;  // these may be anything
  width_ = width;
  height_ = height;
  minimised_ = width_ == 0 || height_ == 0 || glfwGetWindowAttrib(window_, GLFW_ICONIFIED) == GLFW_TRUE;
  pixels_per_unit_ = units > 0 && width_ > 0 ? static_cast<float>(width_) / static_cast<float>(units) : 1.0f;
}

void Window::pause(double pause_s) {
  if (!std::exchange(keeps_keys_, true)) keys_.clear();
  const double until_s = glfwGetTime() + pause_s;
  for (double left_s = pause_s; left_s > 0; left_s = until_s - glfwGetTime()) glfwWaitEventsTimeout(left_s);
}

double Window::refresh_hz() {
  int count = 0;
  GLFWmonitor** monitors = glfwGetMonitors(&count);
  int most_hz = 0;
  for (int i = 0; i < count; ++i) {
    const GLFWvidmode* mode = glfwGetVideoMode(monitors[i]);
    if (mode != nullptr) most_hz = std::max(most_hz, mode->refreshRate);
  }
  return most_hz > 0 ? most_hz : 60;
}

void Window::keep_open() { glfwSetWindowShouldClose(window_, GLFW_FALSE); }

bool Window::wants_close() const { return glfwWindowShouldClose(window_) == GLFW_TRUE; }

void Window::begin_ui() {
  ImGui_ImplVulkan_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGuiIO& io = ImGui::GetIO();
  if (display_is_lost()) io.DisplaySize = {0, 0};  // it may be anything
  const auto held = [&](int left, int right) {
    return glfwGetKey(window_, left) == GLFW_PRESS || glfwGetKey(window_, right) == GLFW_PRESS;
  };
  const std::optional<int> command = taps_.hold(io.KeysDown);
  io.KeyCtrl = held(GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL);
  io.KeyShift = held(GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT);
  if (command) {
    io.KeyCtrl = (*command & GLFW_MOD_CONTROL) != 0;
    io.KeyShift = (*command & GLFW_MOD_SHIFT) != 0;
  }
  if (const auto moment = mouse_.next()) {
    io.MousePos = {moment->x, moment->y};
    std::copy(moment->down.begin(), moment->down.end(), io.MouseDown);
    if (moment->mods) {
      io.KeyCtrl = (*moment->mods & GLFW_MOD_CONTROL) != 0;
      io.KeyShift = (*moment->mods & GLFW_MOD_SHIFT) != 0;
    }
  }
  ImGui::NewFrame();
}

void Window::end_ui() { ImGui::Render(); }

}  // namespace footlight::tools
