#include "drivers/av/libav.h"

#include <array>

#include <dlfcn.h>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/error.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

#include "sim/core/check.h"

namespace footlight::drivers {
namespace {

enum Library { kUtil, kCodec, kFormat, kScale };
constexpr std::size_t kLibraries = 4;

struct Loaded {
  std::array<void*, kLibraries> handles{};
  Status status;
};

// Never unloaded: codecs may leave threads behind.
const Loaded& loaded() {
  static const Loaded all = [] {
    const std::array<std::string, kLibraries> names = {fmt::format("libavutil.so.{}", LIBAVUTIL_VERSION_MAJOR),
                                                       fmt::format("libavcodec.so.{}", LIBAVCODEC_VERSION_MAJOR),
                                                       fmt::format("libavformat.so.{}", LIBAVFORMAT_VERSION_MAJOR),
                                                       fmt::format("libswscale.so.{}", LIBSWSCALE_VERSION_MAJOR)};
    Loaded result;
    for (std::size_t i = 0; i < kLibraries; ++i) {
      result.handles[i] = ::dlopen(names[i].c_str(), RTLD_NOW | RTLD_LOCAL);
      if (result.handles[i] != nullptr) continue;
      result.status = fail(ErrorCode::kUnsupported,
                           "{} cannot be loaded, which sound files and videos need; run 'sudo apt-get install "
                           "libavformat{} libswscale{}'",
                           names[i], LIBAVFORMAT_VERSION_MAJOR, LIBSWSCALE_VERSION_MAJOR);
      break;
    }
    return result;
  }();
  return all;
}

template <class Function>
Function found(Library library, const char* name) {
  void* const address = loaded().status ? ::dlsym(loaded().handles[library], name) : nullptr;
  if (address == nullptr)
    internal::check_failed(__FILE__, __LINE__, name);  // load_libav() was not called or had failed
  return reinterpret_cast<Function>(address);
}

}  // namespace

Status load_libav() { return loaded().status; }

}  // namespace footlight::drivers

// ---- The functions of libav ----

using footlight::drivers::found;
using footlight::drivers::kCodec;
using footlight::drivers::kFormat;
using footlight::drivers::kScale;
using footlight::drivers::kUtil;

// NOLINTBEGIN(bugprone-macro-parentheses): types, parameters and arguments in parentheses of their own
#define FL_PASS_ON(LIBRARY, RESULT, NAME, PARAMETERS, ARGUMENTS)       \
  RESULT NAME PARAMETERS {                                             \
    static const auto call = found<decltype(&::NAME)>(LIBRARY, #NAME); \
    return call ARGUMENTS;                                             \
  }
// NOLINTEND(bugprone-macro-parentheses)

extern "C" {

FL_PASS_ON(kUtil, const char*, av_color_range_name, (AVColorRange range), (range))
FL_PASS_ON(kUtil, const char*, av_color_space_name, (AVColorSpace space), (space))
FL_PASS_ON(kUtil, const char*, av_color_transfer_name, (AVColorTransferCharacteristic transfer), (transfer))
FL_PASS_ON(kUtil, AVRational, av_d2q, (double number, int max), (number, max))
FL_PASS_ON(kUtil, AVFrame*, av_frame_alloc, (), ())
FL_PASS_ON(kUtil, void, av_frame_free, (AVFrame * *frame), (frame))
FL_PASS_ON(kUtil, int, av_frame_get_buffer, (AVFrame * frame, int align), (frame, align))
FL_PASS_ON(kUtil, int, av_frame_make_writable, (AVFrame * frame), (frame))
FL_PASS_ON(kUtil, void, av_freep, (void* pointer), (pointer))
FL_PASS_ON(kUtil, AVSampleFormat, av_get_packed_sample_fmt, (AVSampleFormat format), (format))
FL_PASS_ON(kUtil, const char*, av_get_pix_fmt_name, (AVPixelFormat format), (format))
FL_PASS_ON(kUtil, void, av_log_set_level, (int level), (level))
FL_PASS_ON(kUtil, void*, av_malloc, (std::size_t size), (size))
FL_PASS_ON(kUtil, int, av_opt_set, (void* object, const char* name, const char* value, int flags),
           (object, name, value, flags))
FL_PASS_ON(kUtil, const AVPixFmtDescriptor*, av_pix_fmt_desc_get, (AVPixelFormat format), (format))
FL_PASS_ON(kUtil, std::int64_t, av_rescale_q, (std::int64_t number, AVRational from, AVRational to), (number, from, to))
FL_PASS_ON(kUtil, int, av_sample_fmt_is_planar, (AVSampleFormat format), (format))
FL_PASS_ON(kUtil, int, av_strerror, (int code, char* text, std::size_t size), (code, text, size))

FL_PASS_ON(kCodec, AVPacket*, av_packet_alloc, (), ())
FL_PASS_ON(kCodec, void, av_packet_free, (AVPacket * *packet), (packet))
FL_PASS_ON(kCodec, void, av_packet_rescale_ts, (AVPacket * packet, AVRational from, AVRational to), (packet, from, to))
FL_PASS_ON(kCodec, void, av_packet_unref, (AVPacket * packet), (packet))
FL_PASS_ON(kCodec, AVCodecContext*, avcodec_alloc_context3, (const AVCodec* codec), (codec))
FL_PASS_ON(kCodec, const AVCodec*, avcodec_find_decoder, (AVCodecID id), (id))
FL_PASS_ON(kCodec, const AVCodec*, avcodec_find_encoder, (AVCodecID id), (id))
FL_PASS_ON(kCodec, const AVCodec*, avcodec_find_encoder_by_name, (const char* name), (name))
FL_PASS_ON(kCodec, void, avcodec_free_context, (AVCodecContext * *context), (context))
FL_PASS_ON(kCodec, const char*, avcodec_get_name, (AVCodecID id), (id))
FL_PASS_ON(kCodec, int, avcodec_open2, (AVCodecContext * context, const AVCodec* codec, AVDictionary** options),
           (context, codec, options))
FL_PASS_ON(kCodec, int, avcodec_parameters_from_context,
           (AVCodecParameters * parameters, const AVCodecContext* context), (parameters, context))
FL_PASS_ON(kCodec, int, avcodec_parameters_to_context, (AVCodecContext * context, const AVCodecParameters* parameters),
           (context, parameters))
FL_PASS_ON(kCodec, int, avcodec_receive_frame, (AVCodecContext * context, AVFrame* frame), (context, frame))
FL_PASS_ON(kCodec, int, avcodec_receive_packet, (AVCodecContext * context, AVPacket* packet), (context, packet))
FL_PASS_ON(kCodec, int, avcodec_send_frame, (AVCodecContext * context, const AVFrame* frame), (context, frame))
FL_PASS_ON(kCodec, int, avcodec_send_packet, (AVCodecContext * context, const AVPacket* packet), (context, packet))

FL_PASS_ON(kFormat, int, av_find_best_stream,
           (AVFormatContext * format, AVMediaType type, int wanted, int related, const AVCodec** decoder, int flags),
           (format, type, wanted, related, decoder, flags))
FL_PASS_ON(kFormat, int, av_interleaved_write_frame, (AVFormatContext * format, AVPacket* packet), (format, packet))
FL_PASS_ON(kFormat, int, av_read_frame, (AVFormatContext * format, AVPacket* packet), (format, packet))
FL_PASS_ON(kFormat, int, av_write_trailer, (AVFormatContext * format), (format))
FL_PASS_ON(kFormat, int, avformat_alloc_output_context2,
           (AVFormatContext * *format, const AVOutputFormat* output, const char* name, const char* file),
           (format, output, name, file))
FL_PASS_ON(kFormat, void, avformat_close_input, (AVFormatContext * *format), (format))
FL_PASS_ON(kFormat, int, avformat_find_stream_info, (AVFormatContext * format, AVDictionary** options),
           (format, options))
FL_PASS_ON(kFormat, void, avformat_free_context, (AVFormatContext * format), (format))
FL_PASS_ON(kFormat, AVStream*, avformat_new_stream, (AVFormatContext * format, const AVCodec* codec), (format, codec))
FL_PASS_ON(kFormat, int, avformat_open_input,
           (AVFormatContext * *format, const char* url, const AVInputFormat* input, AVDictionary** options),
           (format, url, input, options))
FL_PASS_ON(kFormat, int, avformat_write_header, (AVFormatContext * format, AVDictionary** options), (format, options))
FL_PASS_ON(kFormat, AVIOContext*, avio_alloc_context,
           (unsigned char* buffer, int size, int writes, void* object, int (*read)(void*, std::uint8_t*, int),
            int (*write)(void*, std::uint8_t*, int), std::int64_t (*seek)(void*, std::int64_t, int)),
           (buffer, size, writes, object, read, write, seek))
FL_PASS_ON(kFormat, int, avio_closep, (AVIOContext * *io), (io))
FL_PASS_ON(kFormat, void, avio_context_free, (AVIOContext * *io), (io))
FL_PASS_ON(kFormat, int, avio_open, (AVIOContext * *io, const char* url, int flags), (io, url, flags))

FL_PASS_ON(kScale, void, sws_freeContext, (SwsContext * context), (context))
FL_PASS_ON(kScale, SwsContext*, sws_getCachedContext,
           (SwsContext * context, int from_width, int from_height, AVPixelFormat from_format, int to_width,
            int to_height, AVPixelFormat to_format, int flags, SwsFilter* from_filter, SwsFilter* to_filter,
            const double* parameters),
           (context, from_width, from_height, from_format, to_width, to_height, to_format, flags, from_filter,
            to_filter, parameters))
FL_PASS_ON(kScale, const int*, sws_getCoefficients, (int space), (space))
FL_PASS_ON(kScale, SwsContext*, sws_getContext,
           (int from_width, int from_height, AVPixelFormat from_format, int to_width, int to_height,
            AVPixelFormat to_format, int flags, SwsFilter* from_filter, SwsFilter* to_filter, const double* parameters),
           (from_width, from_height, from_format, to_width, to_height, to_format, flags, from_filter, to_filter,
            parameters))
FL_PASS_ON(kScale, int, sws_scale,
           (SwsContext * context, const std::uint8_t* const from[], const int from_strides[], int from_y,
            int from_height, std::uint8_t* const to[], const int to_strides[]),
           (context, from, from_strides, from_y, from_height, to, to_strides))
FL_PASS_ON(kScale, int, sws_setColorspaceDetails,
           (SwsContext * context, const int inverse[4], int from_range, const int table[4], int to_range,
            int brightness, int contrast, int saturation),
           (context, inverse, from_range, table, to_range, brightness, contrast, saturation))
}

#undef FL_PASS_ON
