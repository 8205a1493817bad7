#include "render/vk/device.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>

#include "render/vk/pipeline.h"
#include "render/vk/pipeline_cache.h"

namespace footlight::render::vk {
namespace {

constexpr const char* kNoDeviceAdvice =
    "install a driver for your GPU, or 'sudo apt-get install mesa-vulkan-drivers' for the software renderer lavapipe; "
    "'vulkaninfo --summary' (package vulkan-tools) shows what is there";

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

bool layer_has_extension(const char* layer, const char* name) {
  std::uint32_t count = 0;
  vkEnumerateInstanceExtensionProperties(layer, &count, nullptr);
  std::vector<VkExtensionProperties> extensions(count);
  vkEnumerateInstanceExtensionProperties(layer, &count, extensions.data());
  return std::any_of(extensions.begin(), extensions.end(),
                     [&](const VkExtensionProperties& each) { return std::strcmp(each.extensionName, name) == 0; });
}

bool has_layer(const char* name) {
  std::uint32_t count = 0;
  vkEnumerateInstanceLayerProperties(&count, nullptr);
  std::vector<VkLayerProperties> layers(count);
  vkEnumerateInstanceLayerProperties(&count, layers.data());
  return std::any_of(layers.begin(), layers.end(),
                     [&](const VkLayerProperties& layer) { return std::strcmp(layer.layerName, name) == 0; });
}

int rank_of(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU: return 4;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU: return 3;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU: return 2;
    case VK_PHYSICAL_DEVICE_TYPE_CPU: return 1;
    default: return 0;
  }
}

}  // namespace

Status check(VkResult result, const char* call) {
  switch (result) {
    case VK_SUCCESS: return {};
    case VK_ERROR_OUT_OF_HOST_MEMORY: return fail(ErrorCode::kIo, "{}: out of memory", call);
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
      return fail(ErrorCode::kIo, "{}: out of GPU memory; use a smaller picture or fewer fixtures", call);
    case VK_ERROR_DEVICE_LOST:
      return fail(ErrorCode::kDisconnected, "{}: the GPU stopped answering (device lost); see 'sudo dmesg'", call);
    default: return fail(ErrorCode::kIo, "{}: Vulkan error {}", call, static_cast<int>(result));
  }
}

VKAPI_ATTR VkBool32 VKAPI_CALL Device::on_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                  VkDebugUtilsMessageTypeFlagsEXT types,
                                                  const VkDebugUtilsMessengerCallbackDataEXT* data, void* self) {
  // Loader chatter about other drivers is GENERAL; what the program does wrong is VALIDATION or PERFORMANCE.
  if ((types & VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT) == 0) return VK_FALSE;
  if (severity < VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT) return VK_FALSE;
  auto& device = *static_cast<Device*>(self);
  const std::lock_guard lock(device.messages_mutex_);
  device.validation_messages_.emplace_back(data->pMessage);
  fmt::print(stderr, "validation: {}\n", data->pMessage);
  return VK_FALSE;
}

Result<std::unique_ptr<Device>> Device::create(const DeviceOptions& options) {
  std::unique_ptr<Device> device(new Device());
  FL_TRY(device->create_instance(options));
  FL_TRY(device->choose_physical(options));
  FL_TRY(device->create_logical(options));
  FL_TRY(device->create_samplers());
  FL_TRY(device->create_pipeline_cache(options));
  device->pipelines_ = std::make_unique<Pipelines>(*device);
  return device;
}

Status Device::create_instance(const DeviceOptions& options) {
  const char* environment = std::getenv("FOOTLIGHT_VALIDATION");
  const bool validation = options.validation || (environment != nullptr && std::strcmp(environment, "1") == 0);

  std::vector<const char*> layers;
  std::vector<const char*> extensions;
  for (const auto& extension : options.instance_extensions) extensions.push_back(extension.c_str());
  if (validation) {
    if (!has_layer(kValidationLayer)) {
      return fail(ErrorCode::kUnsupported,
                  "the Vulkan validation layer is not installed; 'sudo apt-get install vulkan-validationlayers'");
    }
    layers.push_back(kValidationLayer);
    extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    validates_synchronisation_ = layer_has_extension(kValidationLayer, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
    if (validates_synchronisation_) extensions.push_back(VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
  }

  VkApplicationInfo application{
      VK_STRUCTURE_TYPE_APPLICATION_INFO, nullptr, "footlight", 1, "footlight", 1, VK_API_VERSION_1_3};
  VkDebugUtilsMessengerCreateInfoEXT messenger{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
  messenger.messageSeverity =
      VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
  messenger.pfnUserCallback = &Device::on_message;
  messenger.pUserData = this;

  const VkValidationFeatureEnableEXT synchronisation = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
  VkValidationFeaturesEXT features{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT, &messenger};
  features.enabledValidationFeatureCount = 1;
  features.pEnabledValidationFeatures = &synchronisation;

  VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
  if (validation) info.pNext = validates_synchronisation_ ? static_cast<const void*>(&features) : &messenger;
  info.pApplicationInfo = &application;
  info.enabledLayerCount = static_cast<std::uint32_t>(layers.size());
  info.ppEnabledLayerNames = layers.data();
  info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  if (const VkResult result = vkCreateInstance(&info, nullptr, &instance); result != VK_SUCCESS) {
    return fail(ErrorCode::kUnsupported, "no Vulkan 1.3 on this machine (vkCreateInstance gave {}); {}",
                static_cast<int>(result), kNoDeviceAdvice);
  }
  if (validation) {
    const auto create = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance, "vkCreateDebugUtilsMessengerEXT"));
    FL_TRY(check(create(instance, &messenger, nullptr, &messenger_), "vkCreateDebugUtilsMessengerEXT"));
  }
  return {};
}

Status Device::choose_physical(const DeviceOptions& options) {
  std::uint32_t count = 0;
  vkEnumeratePhysicalDevices(instance, &count, nullptr);
  std::vector<VkPhysicalDevice> devices(count);
  vkEnumeratePhysicalDevices(instance, &count, devices.data());
  int best = -1;
  std::string seen;
  std::string refused;
  for (VkPhysicalDevice candidate : devices) {
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(candidate, &properties);
    seen += fmt::format("{}{} (Vulkan {}.{})", seen.empty() ? "" : ", ", properties.deviceName,
                        VK_API_VERSION_MAJOR(properties.apiVersion), VK_API_VERSION_MINOR(properties.apiVersion));
    if (properties.apiVersion < VK_API_VERSION_1_3) continue;
    if (!options.name_contains.empty() &&
        std::string(properties.deviceName).find(options.name_contains) == std::string::npos) {
      continue;
    }
    if (rank_of(properties.deviceType) <= best) continue;
    DeviceFacts facts = read_facts(candidate);
    if (const Status usable = check_demands(facts); !usable) {
      refused += usable.error().message + "; ";
      continue;
    }
    best = rank_of(properties.deviceType);
    physical = candidate;
    facts_ = facts;
  }
  if (physical == VK_NULL_HANDLE) {
    return fail(ErrorCode::kUnsupported, "no usable Vulkan 1.3 device{}; found: {}; {}{}",
                options.name_contains.empty() ? "" : " named '" + options.name_contains + "'",
                seen.empty() ? "none" : seen, refused, kNoDeviceAdvice);
  }
  name_ = facts_.properties.deviceName;
  driver_ = fmt::format("{} {}", facts_.driver.driverName, facts_.driver.driverInfo);
  software_ = facts_.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
  notes_ = missing_options(facts_);
  if (!refused.empty()) notes_.insert(notes_.begin(), refused + "using " + name_ + " in its place");
  return {};
}

Status Device::create_logical(const DeviceOptions& options) {
  std::uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
  constexpr VkQueueFlags kWanted = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
  const auto family = std::find_if(families.begin(), families.end(), [](const VkQueueFamilyProperties& f) {
    return (f.queueFlags & kWanted) == kWanted;
  });
  if (family == families.end()) {
    return fail(ErrorCode::kUnsupported, "{} has no queue that both draws and computes; {}", name_, kNoDeviceAdvice);
  }
  queue_family = static_cast<std::uint32_t>(family - families.begin());

  const float priority = 1.0f;
  VkDeviceQueueCreateInfo queue_info{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
  queue_info.queueFamilyIndex = queue_family;
  queue_info.queueCount = 1;
  queue_info.pQueuePriorities = &priority;

  VkPhysicalDeviceVulkan13Features features_13{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
  features_13.synchronization2 = VK_TRUE;
  features_13.dynamicRendering = VK_TRUE;
  features_13.maintenance4 = VK_TRUE;
  features_13.subgroupSizeControl = facts_.features_13.subgroupSizeControl;
  VkPhysicalDeviceVulkan12Features features_12{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, &features_13};
  VkPhysicalDeviceFeatures2 features{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &features_12, {}};
  if (has_wide_atomics(facts_)) {  // an option
    features_12.shaderBufferInt64Atomics = VK_TRUE;
    features.features.shaderInt64 = VK_TRUE;
  }
  features.features.multiDrawIndirect = facts_.features.multiDrawIndirect;  // an option
  features.features.drawIndirectFirstInstance = VK_TRUE;
  features.features.shaderStorageImageExtendedFormats = VK_TRUE;

  std::vector<const char*> extensions;
  if (options.swapchain) extensions.push_back(VK_KHR_SWAPCHAIN_EXTENSION_NAME);
  VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &features};
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue_info;
  info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  FL_TRY(check(vkCreateDevice(physical, &info, nullptr, &handle), "vkCreateDevice"));
  vkGetDeviceQueue(handle, queue_family, 0, &queue);

  VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  pool.queueFamilyIndex = queue_family;
  return check(vkCreateCommandPool(handle, &pool, nullptr, &command_pool), "vkCreateCommandPool");
}

Status Device::create_samplers() {
  VkSamplerCreateInfo sampler{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
  sampler.magFilter = VK_FILTER_LINEAR;
  sampler.minFilter = VK_FILTER_LINEAR;
  sampler.mipmapMode = VK_SAMPLER_MIPMAP_MODE_LINEAR;
  sampler.maxLod = VK_LOD_CLAMP_NONE;
  sampler.addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  sampler.addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  sampler.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  FL_TRY(check(vkCreateSampler(handle, &sampler, nullptr, &linear), "vkCreateSampler"));
  sampler.magFilter = VK_FILTER_NEAREST;
  sampler.minFilter = VK_FILTER_NEAREST;
  sampler.mipmapMode = VK_SAMPLER_MIPMAP_MODE_NEAREST;  // depth formats need not be filtered
  return check(vkCreateSampler(handle, &sampler, nullptr, &nearest), "vkCreateSampler");
}

// A file that the driver does not take is as good as none.
Status Device::create_pipeline_cache(const DeviceOptions& options) {
  if (options.cache_folder.empty()) return {};
  cache_path_ = pipeline_cache_path(options.cache_folder, facts_);
  cache_loaded_ = read_pipeline_cache(cache_path_, facts_);
  VkPipelineCacheCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
  info.initialDataSize = cache_loaded_.size();
  info.pInitialData = cache_loaded_.data();
  if (vkCreatePipelineCache(handle, &info, nullptr, &pipeline_cache) == VK_SUCCESS) return {};
  info.initialDataSize = 0;
  return check(vkCreatePipelineCache(handle, &info, nullptr, &pipeline_cache), "vkCreatePipelineCache");
}

// What cannot be written is compiled again next time, so nothing is said.
void Device::save_pipeline_cache() const {
  if (pipeline_cache == VK_NULL_HANDLE || lost_ || pipelines_ == nullptr || pipelines_->compiled() == 0) return;
  std::size_t bytes = 0;
  if (vkGetPipelineCacheData(handle, pipeline_cache, &bytes, nullptr) != VK_SUCCESS) return;
  std::vector<std::byte> data(bytes);
  if (vkGetPipelineCacheData(handle, pipeline_cache, &bytes, data.data()) != VK_SUCCESS) return;
  data.resize(bytes);
  if (data != cache_loaded_) (void)write_pipeline_cache(cache_path_, facts_, data);
}

Device::~Device() {
  if (handle != VK_NULL_HANDLE) {
    vkDeviceWaitIdle(handle);
    if (pipelines_) pipelines_->stop();
    save_pipeline_cache();
    pipelines_.reset();
    vkDestroyPipelineCache(handle, pipeline_cache, nullptr);
    vkDestroySampler(handle, linear, nullptr);
    vkDestroySampler(handle, nearest, nullptr);
    vkDestroyCommandPool(handle, command_pool, nullptr);
    vkDestroyDevice(handle, nullptr);
  }
  if (messenger_ != VK_NULL_HANDLE) {
    const auto destroy = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance, "vkDestroyDebugUtilsMessengerEXT"));
    destroy(instance, messenger_, nullptr);
  }
  if (instance != VK_NULL_HANDLE) vkDestroyInstance(instance, nullptr);
}

Result<std::uint32_t> Device::memory_type(std::uint32_t type_bits, VkMemoryPropertyFlags flags) const {
  VkPhysicalDeviceMemoryProperties memory;
  vkGetPhysicalDeviceMemoryProperties(physical, &memory);
  for (std::uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
    if ((type_bits & (1u << i)) != 0 && (memory.memoryTypes[i].propertyFlags & flags) == flags) return i;
  }
  return fail(ErrorCode::kUnsupported, "{} has no memory type with properties {:#x}", name_, flags);
}

Result<VkCommandBuffer> Device::begin_once() {
  VkCommandBufferAllocateInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  info.commandPool = command_pool;
  info.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  info.commandBufferCount = 1;
  VkCommandBuffer commands = VK_NULL_HANDLE;
  FL_TRY(check(vkAllocateCommandBuffers(handle, &info, &commands), "vkAllocateCommandBuffers"));
  VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  FL_TRY(check(vkBeginCommandBuffer(commands, &begin), "vkBeginCommandBuffer"));
  return commands;
}

Status Device::end_once(VkCommandBuffer commands) {
  FL_TRY(check(vkEndCommandBuffer(commands), "vkEndCommandBuffer"));
  VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &commands;
  const VkFenceCreateInfo info{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  VkFence done = VK_NULL_HANDLE;
  FL_TRY(check(vkCreateFence(handle, &info, nullptr, &done), "vkCreateFence"));
  Status status;
  {
    const std::lock_guard lock(queue_mutex);
    status = submit_locked(submit, done);
  }
  if (status) status = wait(done);
  vkDestroyFence(handle, done, nullptr);
  vkFreeCommandBuffers(handle, command_pool, 1, &commands);
  return status;
}

Status Device::submit_locked(const VkSubmitInfo& batch, VkFence done) {
  if (submits_left_ == 0) lost_ = true;
  if (submits_left_ != UINT64_MAX && submits_left_ > 0) --submits_left_;
  const VkResult result = lost_ ? VK_ERROR_DEVICE_LOST : vkQueueSubmit(queue, 1, &batch, done);
  if (result == VK_ERROR_DEVICE_LOST) lost_ = true;
  return check(result, "vkQueueSubmit");
}

Status Device::wait(VkFence fence) {
  const VkResult result = lost_ ? VK_ERROR_DEVICE_LOST : vkWaitForFences(handle, 1, &fence, VK_TRUE, UINT64_MAX);
  if (result == VK_ERROR_DEVICE_LOST) lost_ = true;
  return check(result, "vkWaitForFences");
}

void Device::lose_from_environment() {
  static std::atomic<bool> first = true;
  const char* text = std::getenv("FOOTLIGHT_LOSE_DEVICE");
  if (text != nullptr && first.exchange(false)) lose_after(std::strtoull(text, nullptr, 10));
}

void Device::add_memory(std::uint64_t bytes) {
  const std::uint64_t now = memory_bytes_ += bytes;
  std::uint64_t peak = memory_peak_bytes_;
  while (now > peak && !memory_peak_bytes_.compare_exchange_weak(peak, now)) {
  }
}

Status Device::wait_idle() {
  const std::lock_guard lock(queue_mutex);
  return check(vkDeviceWaitIdle(handle), "vkDeviceWaitIdle");
}

}  // namespace footlight::render::vk
