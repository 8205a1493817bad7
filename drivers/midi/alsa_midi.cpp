#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>

#include <alsa/asoundlib.h>
#include <dlfcn.h>
#include <poll.h>

#include "drivers/midi/midi_device.h"

namespace footlight::drivers {
namespace {

// The functions of libasound that are used, found when it is loaded.
struct AlsaSequencer {
  decltype(&::snd_seq_open) open = nullptr;
  decltype(&::snd_seq_close) close = nullptr;
  decltype(&::snd_seq_set_client_name) set_client_name = nullptr;
  decltype(&::snd_seq_create_simple_port) create_port = nullptr;
  decltype(&::snd_seq_connect_from) connect_from = nullptr;
  decltype(&::snd_seq_poll_descriptors) poll_descriptors = nullptr;
  decltype(&::snd_seq_event_input) event_input = nullptr;
  decltype(&::snd_seq_client_id) client_id = nullptr;
  decltype(&::snd_seq_client_info_malloc) client_malloc = nullptr;
  decltype(&::snd_seq_client_info_free) client_free = nullptr;
  decltype(&::snd_seq_client_info_set_client) client_set = nullptr;
  decltype(&::snd_seq_client_info_get_client) client_get = nullptr;
  decltype(&::snd_seq_client_info_get_name) client_name = nullptr;
  decltype(&::snd_seq_query_next_client) next_client = nullptr;
  decltype(&::snd_seq_port_info_malloc) port_malloc = nullptr;
  decltype(&::snd_seq_port_info_free) port_free = nullptr;
  decltype(&::snd_seq_port_info_set_client) port_set_client = nullptr;
  decltype(&::snd_seq_port_info_set_port) port_set = nullptr;
  decltype(&::snd_seq_port_info_get_port) port_get = nullptr;
  decltype(&::snd_seq_port_info_get_name) port_name = nullptr;
  decltype(&::snd_seq_port_info_get_capability) port_capability = nullptr;
  decltype(&::snd_seq_query_next_port) next_port = nullptr;
  decltype(&::snd_strerror) text = nullptr;
  decltype(&::snd_lib_error_set_handler) set_handler = nullptr;
};

void ignore_message_of_alsa(const char*, int, const char*, int, const char*, ...) {}  // NOLINT(cert-dcl50-cpp): of ALSA

template <class Function>
bool find_in(void* library, const char* name, Function& function) {
  function = reinterpret_cast<Function>(::dlsym(library, name));
  return function != nullptr;
}

Result<const AlsaSequencer*> load_sequencer() {
  static const AlsaSequencer* const loaded = []() -> const AlsaSequencer* {
    void* library = ::dlopen("libasound.so.2", RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) return nullptr;
    static AlsaSequencer alsa;
    const bool complete =
        find_in(library, "snd_seq_open", alsa.open) && find_in(library, "snd_seq_close", alsa.close) &&
        find_in(library, "snd_seq_set_client_name", alsa.set_client_name) &&
        find_in(library, "snd_seq_create_simple_port", alsa.create_port) &&
        find_in(library, "snd_seq_connect_from", alsa.connect_from) &&
        find_in(library, "snd_seq_poll_descriptors", alsa.poll_descriptors) &&
        find_in(library, "snd_seq_event_input", alsa.event_input) &&
        find_in(library, "snd_seq_client_id", alsa.client_id) &&
        find_in(library, "snd_seq_client_info_malloc", alsa.client_malloc) &&
        find_in(library, "snd_seq_client_info_free", alsa.client_free) &&
        find_in(library, "snd_seq_client_info_set_client", alsa.client_set) &&
        find_in(library, "snd_seq_client_info_get_client", alsa.client_get) &&
        find_in(library, "snd_seq_client_info_get_name", alsa.client_name) &&
        find_in(library, "snd_seq_query_next_client", alsa.next_client) &&
        find_in(library, "snd_seq_port_info_malloc", alsa.port_malloc) &&
        find_in(library, "snd_seq_port_info_free", alsa.port_free) &&
        find_in(library, "snd_seq_port_info_set_client", alsa.port_set_client) &&
        find_in(library, "snd_seq_port_info_set_port", alsa.port_set) &&
        find_in(library, "snd_seq_port_info_get_port", alsa.port_get) &&
        find_in(library, "snd_seq_port_info_get_name", alsa.port_name) &&
        find_in(library, "snd_seq_port_info_get_capability", alsa.port_capability) &&
        find_in(library, "snd_seq_query_next_port", alsa.next_port) && find_in(library, "snd_strerror", alsa.text) &&
        find_in(library, "snd_lib_error_set_handler", alsa.set_handler);
    if (!complete) return nullptr;
    alsa.set_handler(ignore_message_of_alsa);  // errors are returned
    return &alsa;
  }();
  if (loaded == nullptr) {
    return fail(ErrorCode::kUnsupported, "libasound.so.2 cannot be loaded; run 'sudo apt-get install libasound2'");
  }
  return loaded;
}

struct Port {
  int client = 0;
  int port = 0;
  std::string name;
};

// Every port of another client from which events can be received, without those of the system.
std::vector<Port> ports_of(const AlsaSequencer& alsa, snd_seq_t* sequencer) {
  constexpr unsigned kNeeded = SND_SEQ_PORT_CAP_READ | SND_SEQ_PORT_CAP_SUBS_READ;
  std::vector<Port> ports;
  snd_seq_client_info_t* client = nullptr;
  snd_seq_port_info_t* port = nullptr;
  if (alsa.client_malloc(&client) < 0) return ports;
  if (alsa.port_malloc(&port) < 0) {
    alsa.client_free(client);
    return ports;
  }
  alsa.client_set(client, -1);
  while (alsa.next_client(sequencer, client) >= 0) {
    const int number = alsa.client_get(client);
    if (number == SND_SEQ_CLIENT_SYSTEM || number == alsa.client_id(sequencer)) continue;
    alsa.port_set_client(port, number);
    alsa.port_set(port, -1);
    while (alsa.next_port(sequencer, port) >= 0) {
      if ((alsa.port_capability(port) & kNeeded) != kNeeded) continue;
      ports.push_back(
          {number, alsa.port_get(port), fmt::format("{} {}", alsa.client_name(client), alsa.port_name(port))});
    }
  }
  alsa.port_free(port);
  alsa.client_free(client);
  return ports;
}

class AlsaMidi final : public MidiDevice {
 public:
  AlsaMidi(const AlsaSequencer& alsa, snd_seq_t* sequencer, std::string name)
      : alsa_(alsa), sequencer_(sequencer), name_(std::move(name)) {}
  ~AlsaMidi() override { alsa_.close(sequencer_); }
  AlsaMidi(const AlsaMidi&) = delete;
  AlsaMidi& operator=(const AlsaMidi&) = delete;

  Status connect() {
    alsa_.set_client_name(sequencer_, "Footlight");
    own_port_ = alsa_.create_port(sequencer_, "in", SND_SEQ_PORT_CAP_WRITE | SND_SEQ_PORT_CAP_SUBS_WRITE,
                                  SND_SEQ_PORT_TYPE_APPLICATION);
    if (own_port_ < 0) return fail(ErrorCode::kIo, "midi:{}: {}", name_, alsa_.text(own_port_));
    pollfd wait = {};
    if (alsa_.poll_descriptors(sequencer_, &wait, 1, POLLIN) < 1) {
      return fail(ErrorCode::kIo, "midi:{}: gives no descriptor to wait for", name_);
    }
    fd_ = wait.fd;
    return reconnect();
  }

  Status reconnect() override {
    std::string list;
    for (const Port& port : ports_of(alsa_, sequencer_)) {
      const std::string numbers = fmt::format("{}:{}", port.client, port.port);
      list += fmt::format("{}'{}'", list.empty() ? "" : ", ", port.name);
      if (numbers != name_ && (name_.empty() || port.name.find(name_) == std::string::npos)) continue;
      const int connected = alsa_.connect_from(sequencer_, own_port_, port.client, port.port);
      if (connected < 0) return fail(ErrorCode::kIo, "midi:{}: {}: {}", name_, port.name, alsa_.text(connected));
      return {};
    }
    return fail(ErrorCode::kNotFound, "midi:{}: no MIDI device has this in its name; there {} {}", name_,
                list.empty() ? "are" : "is", list.empty() ? "none; plug one in, or use midi:mock" : list);
  }

  [[nodiscard]] int poll_fd() const override { return fd_; }
  [[nodiscard]] std::uint64_t overruns() const override { return overruns_; }

  Status read(std::vector<MidiEvent>& into, TimeNs /*now_ns*/) override {
    while (true) {
      snd_seq_event_t* event = nullptr;
      const int got = alsa_.event_input(sequencer_, &event);
      if (got == -EAGAIN) return {};
      if (got == -ENOSPC) {
        ++overruns_;
        continue;
      }
      if (got < 0) return fail(ErrorCode::kDisconnected, "midi:{}: {}", name_, alsa_.text(got));
      if (event == nullptr) return {};
      if (event->type == SND_SEQ_EVENT_PORT_UNSUBSCRIBED) {
        return fail(ErrorCode::kDisconnected, "midi:{}: unplugged", name_);
      }
      add(*event, into);
    }
  }

 private:
  static void add(const snd_seq_event_t& event, std::vector<MidiEvent>& into) {
    const auto& control = event.data.control;
    const auto& note = event.data.note;
    switch (event.type) {
      case SND_SEQ_EVENT_CONTROLLER:
        into.push_back({MidiKind::kController, control.channel % 16 + 1, static_cast<int>(control.param % 128),
                        std::clamp(control.value, 0, 127)});
        break;
      case SND_SEQ_EVENT_PITCHBEND:
        into.push_back(
            {MidiKind::kPitchBend, control.channel % 16 + 1, 0, std::clamp(control.value + 8'192, 0, 16'383)});
        break;
      case SND_SEQ_EVENT_NOTEON:
        into.push_back({MidiKind::kNote, note.channel % 16 + 1, note.note % 128, std::min<int>(note.velocity, 127)});
        break;
      case SND_SEQ_EVENT_NOTEOFF: into.push_back({MidiKind::kNote, note.channel % 16 + 1, note.note % 128, 0}); break;
      default: break;
    }
  }

  const AlsaSequencer& alsa_;
  snd_seq_t* sequencer_;
  std::string name_;
  int own_port_ = -1;
  int fd_ = -1;
  std::uint64_t overruns_ = 0;
};

}  // namespace

Result<std::unique_ptr<MidiDevice>> open_alsa_midi(const std::string& name) {
  FL_ASSIGN(const AlsaSequencer* alsa, load_sequencer());
  snd_seq_t* sequencer = nullptr;
  const int code = alsa->open(&sequencer, "default", SND_SEQ_OPEN_INPUT, SND_SEQ_NONBLOCK);
  if (code < 0) {
    const ErrorCode kind = code == -EACCES || code == -EPERM ? ErrorCode::kPermission : ErrorCode::kNotFound;
    return fail(kind, "midi:{}: ALSA's sequencer cannot be opened: {}; run 'sudo modprobe snd-seq', or use midi:mock",
                name, alsa->text(code));
  }
  auto device = std::make_unique<AlsaMidi>(*alsa, sequencer, name);
  FL_TRY(device->connect());
  return device;
}

}  // namespace footlight::drivers
