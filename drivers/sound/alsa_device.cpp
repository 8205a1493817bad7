#include <array>
#include <cerrno>
#include <thread>

#include <alsa/asoundlib.h>
#include <dlfcn.h>

#include "drivers/sound/sound_device.h"

namespace footlight::drivers {
namespace {

constexpr int kChannels = 2;
constexpr int kRateHz = 48'000;
constexpr unsigned kLatencyUs = 60'000;  // of the device's buffer: a late reader loses samples after this time
constexpr std::size_t kFramesPerRead = 480;

// The functions of libasound that are used, found when it is loaded.
struct Alsa {
  decltype(&::snd_pcm_open) open = nullptr;
  decltype(&::snd_pcm_close) close = nullptr;
  decltype(&::snd_pcm_set_params) set_params = nullptr;
  decltype(&::snd_pcm_start) start = nullptr;
  decltype(&::snd_pcm_prepare) prepare = nullptr;
  decltype(&::snd_pcm_wait) wait = nullptr;
  decltype(&::snd_pcm_readi) read = nullptr;
  decltype(&::snd_strerror) text = nullptr;
  decltype(&::snd_lib_error_set_handler) set_handler = nullptr;
};

void ignore_message(const char*, int, const char*, int, const char*, ...) {}  // NOLINT(cert-dcl50-cpp): of ALSA

template <class Function>
bool find(void* library, const char* name, Function& function) {
  function = reinterpret_cast<Function>(::dlsym(library, name));
  return function != nullptr;
}

// Never unloaded: PipeWire's plugin leaves threads behind.
Result<const Alsa*> load_alsa() {
  static const Alsa* const loaded = []() -> const Alsa* {
    void* library = ::dlopen("libasound.so.2", RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) return nullptr;
    static Alsa alsa;
    const bool complete = find(library, "snd_pcm_open", alsa.open) && find(library, "snd_pcm_close", alsa.close) &&
                          find(library, "snd_pcm_set_params", alsa.set_params) &&
                          find(library, "snd_pcm_start", alsa.start) &&
                          find(library, "snd_pcm_prepare", alsa.prepare) && find(library, "snd_pcm_wait", alsa.wait) &&
                          find(library, "snd_pcm_readi", alsa.read) && find(library, "snd_strerror", alsa.text) &&
                          find(library, "snd_lib_error_set_handler", alsa.set_handler);
    if (!complete) return nullptr;
    // Its own messages go nowhere: errors are returned.
    alsa.set_handler(ignore_message);
    return &alsa;
  }();
  if (loaded == nullptr) {
    return fail(ErrorCode::kUnsupported, "libasound.so.2 cannot be loaded; run 'sudo apt-get install libasound2'");
  }
  return loaded;
}

class AlsaDevice final : public SoundDevice {
 public:
  AlsaDevice(const Alsa& alsa, snd_pcm_t* pcm, std::string name)
      : alsa_(alsa), pcm_(pcm), name_(std::move(name)), info_{kRateHz, kChannels, "alsa", name_} {}
  ~AlsaDevice() override { alsa_.close(pcm_); }
  AlsaDevice(const AlsaDevice&) = delete;
  AlsaDevice& operator=(const AlsaDevice&) = delete;

  [[nodiscard]] const SoundInfo& info() const override { return info_; }
  [[nodiscard]] std::uint64_t overruns() const override { return overruns_; }

  Status read(std::vector<float>& interleaved, DurationNs timeout_ns) override {
    interleaved.clear();
    const int waited = alsa_.wait(pcm_, static_cast<int>(timeout_ns / kNsPerMs));
    if (waited == 0) return {};
    interleaved.resize(kFramesPerRead * kChannels);
    const snd_pcm_sframes_t got = waited < 0 ? waited : alsa_.read(pcm_, interleaved.data(), kFramesPerRead);
    interleaved.resize(got > 0 ? static_cast<std::size_t>(got) * kChannels : 0);
    if (got >= 0 || got == -EAGAIN) return {};
    const int code = static_cast<int>(got);
    if (code != -EPIPE) return gone(code);
    ++overruns_;
    if (const int prepared = alsa_.prepare(pcm_); prepared < 0) return gone(prepared);
    if (const int started = alsa_.start(pcm_); started < 0) return gone(started);
    return {};
  }

 private:
  Status gone(int code) const { return fail(ErrorCode::kDisconnected, "alsa:{}: {}", name_, alsa_.text(code)); }

  const Alsa& alsa_;
  snd_pcm_t* pcm_;
  std::string name_;
  SoundInfo info_;
  std::uint64_t overruns_ = 0;
};

}  // namespace

Result<std::unique_ptr<SoundDevice>> SoundDevice::open(const std::string& name) {
  const std::string device = name.empty() ? "default" : name;
  FL_ASSIGN(const Alsa* alsa, load_alsa());
  snd_pcm_t* pcm = nullptr;
  int code = alsa->open(&pcm, device.c_str(), SND_PCM_STREAM_CAPTURE, SND_PCM_NONBLOCK);
  if (code < 0) {
    const ErrorCode kind = code == -EACCES || code == -EPERM ? ErrorCode::kPermission
                           : code == -EBUSY                  ? ErrorCode::kIo
                                                             : ErrorCode::kNotFound;
    return fail(kind, "alsa:{}: {}; 'arecord -L' lists the devices", device, alsa->text(code));
  }
  auto opened = std::make_unique<AlsaDevice>(*alsa, pcm, device);
  code = alsa->set_params(pcm, SND_PCM_FORMAT_FLOAT, SND_PCM_ACCESS_RW_INTERLEAVED, kChannels, kRateHz, 1, kLatencyUs);
  if (code >= 0) code = alsa->start(pcm);
  if (code < 0) {
    return fail(ErrorCode::kIo, "alsa:{}: gives no stereo at {} Hz: {}; try alsa:plug{}", device, kRateHz,
                alsa->text(code), device);
  }
  return opened;
}

}  // namespace footlight::drivers
