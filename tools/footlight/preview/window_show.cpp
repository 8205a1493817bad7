// What a window shows: the picture, Dear ImGui over it, and copies of both for files.
#include <algorithm>
#include <cstring>
#include <mutex>
#include <utility>

#include <imgui/backends/imgui_impl_vulkan.h>
#include <imgui/imgui.h>

#include "tools/footlight/preview/window.h"

namespace footlight::tools {
namespace {

namespace vk = render::vk;

constexpr std::uint64_t kAcquirePatienceNs = 1'000'000'000;

void change_layout(VkCommandBuffer commands, VkImage image, VkImageLayout from, VkImageLayout to) {
  render::vk::change_layout(commands, image, VK_IMAGE_ASPECT_COLOR_BIT, from, to);
}

}  // namespace

Status Window::wait_gpu() { return device_->wait(done_); }

void Window::record_shot(VkCommandBuffer commands, VkImage image) {
  change_layout(commands, image, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  VkBufferImageCopy region{};
  region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  region.imageExtent = {extent_.width, extent_.height, 1};
  vkCmdCopyImageToBuffer(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, shot_.handle, 1, &region);
  vk::host_barrier(commands);
  change_layout(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR);
}

// The pictures and black around them.
void Window::record_pictures(VkCommandBuffer commands, VkImage target) {
  const PixelRect whole{0, 0, static_cast<int>(extent_.width), static_cast<int>(extent_.height)};
  const bool covered = places_.size() == 1 && places_[0] == whole && pictures_[0].image() != VK_NULL_HANDLE;
  if (!covered) {
    const VkClearColorValue black{{0, 0, 0, 1}};
    const VkImageSubresourceRange range{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    vkCmdClearColorImage(commands, target, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &black, 1, &range);
    change_layout(commands, target, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
  }
  for (std::size_t i = 0; i < places_.size(); ++i) record_picture(commands, target, pictures_[i], places_[i]);
}

void Window::record_picture(VkCommandBuffer commands, VkImage target, const UploadedImage& picture,
                            const PixelRect& place) {
  if (picture.image() == VK_NULL_HANDLE) return;
  const auto width = static_cast<int>(extent_.width);
  const auto height = static_cast<int>(extent_.height);
  const int left = std::clamp(place.x, 0, width);
  const int top = std::clamp(place.y, 0, height);
  const int right = std::clamp(place.x + place.width, left, width);
  const int bottom = std::clamp(place.y + place.height, top, height);
  if (right == left || bottom == top) return;
  VkImageBlit blit{};
  blit.srcSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  blit.srcOffsets[1] = {picture.width(), picture.height(), 1};
  blit.dstSubresource = blit.srcSubresource;
  blit.dstOffsets[0] = {left, top, 0};
  blit.dstOffsets[1] = {right, bottom, 1};
  const bool same_size = right - left == picture.width() && bottom - top == picture.height();
  vkCmdBlitImage(commands, picture.image(), VK_IMAGE_LAYOUT_GENERAL, target, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1,
                 &blit, same_size ? VK_FILTER_NEAREST : VK_FILTER_LINEAR);
}

void Window::record_ui(VkCommandBuffer commands, const VkFramebuffer& target) {
  VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
  begin.renderPass = render_pass_;
  begin.framebuffer = target;
  begin.renderArea.extent = extent_;
  vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
  ImGui_ImplVulkan_RenderDrawData(ImGui::GetDrawData(), commands);
  vkCmdEndRenderPass(commands);
}

Status Window::set_picture(int view, const HostPicture& picture) {
  FL_TRY(wait_gpu());
  return pictures_[static_cast<std::size_t>(view)].set(*device_, picture);
}

Status Window::set_pictures(PictureShelf& pictures) {
  if (fonts_are_old_) FL_TRY(remake_fonts());
  const ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
  const ImFontAtlasCustomRect& rect = atlas.CustomRects[shelf_rect_];
  if (!rect.IsPacked()) {  // no room: panels have no pictures
    pictures.area.reset();
    return {};
  }
  const auto width = static_cast<float>(atlas.TexWidth);
  const auto height = static_cast<float>(atlas.TexHeight);
  pictures.area = PictureShelf::Place{rect.X / width, rect.Y / height, (rect.X + rect.Width) / width,
                                      (rect.Y + rect.Height) / height};
  if (shelf_revision_ == pictures.revision()) return {};
  FL_TRY(wait_gpu());
  if (shelf_bytes_.mapped == nullptr) {
    FL_ASSIGN(shelf_bytes_, vk::Buffer::host_visible(*device_, pictures.rgba().size(), 0));
  }
  std::memcpy(shelf_bytes_.mapped, pictures.rgba().data(), pictures.rgba().size());
  shelf_revision_ = pictures.revision();
  shelf_fresh_ = true;
  return {};
}

// Into the image that ImGui's renderer has made of its glyphs, and which is its texture (1.86).
void Window::record_shelf(VkCommandBuffer commands) {
  if (!std::exchange(shelf_fresh_, false)) return;
  const ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
  const ImFontAtlasCustomRect& rect = atlas.CustomRects[shelf_rect_];
  const auto image = reinterpret_cast<VkImage>(atlas.TexID);
  change_layout(commands, image, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
  VkBufferImageCopy region{};
  region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  region.imageOffset = {rect.X, rect.Y, 0};
  region.imageExtent = {rect.Width, rect.Height, 1};
  vkCmdCopyBufferToImage(commands, shelf_bytes_.handle, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
  change_layout(commands, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
}

Status Window::drop_pictures(int from_view) {
  FL_TRY(wait_gpu());
  for (auto i = static_cast<std::size_t>(from_view); i < pictures_.size(); ++i) pictures_[i] = {};
  return {};
}

Result<Window::Shown> Window::show(std::span<const PixelRect> places) {
  if (static_cast<int>(extent_.width) != width_ || static_cast<int>(extent_.height) != height_) stale_ = true;
  const bool fresh = std::any_of(pictures_.begin(), pictures_.end(), [](const auto& one) { return one.is_fresh(); });
  const bool moved = !std::equal(places.begin(), places.end(), places_.begin(), places_.end());
  const bool changes = shown_.changes(*ImGui::GetDrawData()) || fresh || shelf_fresh_ || moved;
  if (!changes && !stale_ && !damaged_ && !shot_wanted_) return Shown::kSame;
  damaged_ = true;  // until it is shown
  places_.assign(places.begin(), places.end());
  FL_TRY(wait_gpu());
  if (stale_) FL_TRY(create_swapchain());
  if (stale_) return Shown::kLater;
  std::uint32_t index = 0;
  const VkResult acquired =
      vkAcquireNextImageKHR(device_->handle, swapchain_, kAcquirePatienceNs, acquired_, VK_NULL_HANDLE, &index);
  if (acquired == VK_ERROR_OUT_OF_DATE_KHR) stale_ = true;
  if (acquired == VK_ERROR_OUT_OF_DATE_KHR || acquired == VK_TIMEOUT || acquired == VK_NOT_READY) return Shown::kLater;
  if (acquired == VK_SUBOPTIMAL_KHR) {
    stale_ = true;  // this image is still usable
  } else {
    FL_TRY(vk::check(acquired, "vkAcquireNextImageKHR"));
  }
  const bool shot = shot_wanted_ && readable_;
  if (shot) {
    shot_extent_ = extent_;
    FL_ASSIGN(shot_, vk::Buffer::host_visible(*device_, VkDeviceSize{extent_.width} * extent_.height * 4, 0));
  }
  shot_wanted_ = false;

  VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  FL_TRY(vk::check(vkBeginCommandBuffer(commands_, &begin), "vkBeginCommandBuffer"));
  const Target& target = targets_[index];
  for (UploadedImage& picture : pictures_) picture.record(commands_);
  record_shelf(commands_);
  change_layout(commands_, target.image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
  record_pictures(commands_, target.image);
  record_ui(commands_, target.framebuffer);
  if (shot) record_shot(commands_, target.image);
  FL_TRY(vk::check(vkEndCommandBuffer(commands_), "vkEndCommandBuffer"));
  FL_TRY(present(index));
  damaged_ = stale_;
  return Shown::kNew;
}

// Submits the commands that draw into this target, and presents it.
Status Window::present(std::uint32_t index) {
  const VkPipelineStageFlags wait_stage = VK_PIPELINE_STAGE_TRANSFER_BIT;
  VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
  submit.waitSemaphoreCount = 1;
  submit.pWaitSemaphores = &acquired_;
  submit.pWaitDstStageMask = &wait_stage;
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &commands_;
  submit.signalSemaphoreCount = 1;
  submit.pSignalSemaphores = &targets_[index].drawn;
  FL_TRY(vk::check(vkResetFences(device_->handle, 1, &done_), "vkResetFences"));
  std::unique_lock lock(device_->queue_mutex);
  FL_TRY(device_->submit_locked(submit, done_));

  VkPresentInfoKHR present{VK_STRUCTURE_TYPE_PRESENT_INFO_KHR};
  present.waitSemaphoreCount = 1;
  present.pWaitSemaphores = &targets_[index].drawn;
  present.swapchainCount = 1;
  present.pSwapchains = &swapchain_;
  present.pImageIndices = &index;
  const VkResult presented = vkQueuePresentKHR(device_->queue, &present);
  lock.unlock();
  if (presented == VK_ERROR_OUT_OF_DATE_KHR || presented == VK_SUBOPTIMAL_KHR) {
    stale_ = true;
    return {};
  }
  return vk::check(presented, "vkQueuePresentKHR");
}

Result<render::ScreenImage> Window::read_shot() {
  FL_TRY(wait_gpu());
  render::ScreenImage image;
  if (shot_.mapped == nullptr) return image;
  image.width = static_cast<int>(shot_extent_.width);
  image.height = static_cast<int>(shot_extent_.height);
  image.rgba.resize(shot_.size_bytes);
  std::memcpy(image.rgba.data(), shot_.mapped, image.rgba.size());
  for (std::size_t i = 0; i + 3 < image.rgba.size(); i += 4) {
    if (format_.format == VK_FORMAT_B8G8R8A8_UNORM) std::swap(image.rgba[i], image.rgba[i + 2]);
    image.rgba[i + 3] = 255;
  }
  return image;
}

}  // namespace footlight::tools
