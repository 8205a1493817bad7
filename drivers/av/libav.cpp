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
      const char* const reason = ::dlerror();
      result.status = fail(ErrorCode::kUnsupported,
                           "{} cannot be loaded, which sound files and videos need ({}); run 'sudo apt-get install "
                           "libavformat{} libswscale{}'",
                           names[i], reason == nullptr ? "no reason was given" : reason, LIBAVFORMAT_VERSION_MAJOR,
                           LIBSWSCALE_VERSION_MAJOR);
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

// NOLINTBEGIN(readability-identifier-naming): functions and parameters are named as in libav's headers
// clang-format off
extern "C" {

FL_PASS_ON(kUtil, const char*, av_color_range_name, (AVColorRange range), (range))
FL_PASS_ON(kUtil, const char*, av_color_space_name, (AVColorSpace space), (space))
FL_PASS_ON(kUtil, const char*, av_color_transfer_name, (AVColorTransferCharacteristic transfer), (transfer))
FL_PASS_ON(kUtil, AVRational, av_d2q, (double d, int max), (d, max))
FL_PASS_ON(kUtil, AVFrame*, av_frame_alloc, (), ())
FL_PASS_ON(kUtil, void, av_frame_free, (AVFrame** frame), (frame))
FL_PASS_ON(kUtil, int, av_frame_get_buffer, (AVFrame* frame, int align), (frame, align))
FL_PASS_ON(kUtil, int, av_frame_make_writable, (AVFrame* frame), (frame))
FL_PASS_ON(kUtil, void, av_freep, (void* ptr), (ptr))
FL_PASS_ON(kUtil, AVSampleFormat, av_get_packed_sample_fmt, (AVSampleFormat sample_fmt), (sample_fmt))
FL_PASS_ON(kUtil, const char*, av_get_pix_fmt_name, (AVPixelFormat pix_fmt), (pix_fmt))
FL_PASS_ON(kUtil, void, av_log_set_level, (int level), (level))
FL_PASS_ON(kUtil, void*, av_malloc, (std::size_t size), (size))
FL_PASS_ON(kUtil, int, av_opt_set,
           (void* obj, const char* name, const char* val, int search_flags),
           (obj, name, val, search_flags))
FL_PASS_ON(kUtil, const AVPixFmtDescriptor*, av_pix_fmt_desc_get, (AVPixelFormat pix_fmt), (pix_fmt))
FL_PASS_ON(kUtil, std::int64_t, av_rescale_q, (std::int64_t a, AVRational bq, AVRational cq), (a, bq, cq))
FL_PASS_ON(kUtil, int, av_sample_fmt_is_planar, (AVSampleFormat sample_fmt), (sample_fmt))
FL_PASS_ON(kUtil, int, av_strerror, (int errnum, char* errbuf, std::size_t errbuf_size), (errnum, errbuf, errbuf_size))

FL_PASS_ON(kCodec, AVPacket*, av_packet_alloc, (), ())
FL_PASS_ON(kCodec, void, av_packet_free, (AVPacket** pkt), (pkt))
FL_PASS_ON(kCodec, void, av_packet_rescale_ts,
           (AVPacket* pkt, AVRational tb_src, AVRational tb_dst),
           (pkt, tb_src, tb_dst))
FL_PASS_ON(kCodec, void, av_packet_unref, (AVPacket* pkt), (pkt))
FL_PASS_ON(kCodec, AVCodecContext*, avcodec_alloc_context3, (const AVCodec* codec), (codec))
FL_PASS_ON(kCodec, const AVCodec*, avcodec_find_decoder, (AVCodecID id), (id))
FL_PASS_ON(kCodec, const AVCodec*, avcodec_find_encoder, (AVCodecID id), (id))
FL_PASS_ON(kCodec, const AVCodec*, avcodec_find_encoder_by_name, (const char* name), (name))
FL_PASS_ON(kCodec, void, avcodec_flush_buffers, (AVCodecContext* avctx), (avctx))
FL_PASS_ON(kCodec, void, avcodec_free_context, (AVCodecContext** avctx), (avctx))
FL_PASS_ON(kCodec, const char*, avcodec_get_name, (AVCodecID id), (id))
FL_PASS_ON(kCodec, int, avcodec_open2,
           (AVCodecContext* avctx, const AVCodec* codec, AVDictionary** options),
           (avctx, codec, options))
FL_PASS_ON(kCodec, int, avcodec_parameters_from_context,
           (AVCodecParameters* par, const AVCodecContext* codec),
           (par, codec))
FL_PASS_ON(kCodec, int, avcodec_parameters_to_context,
           (AVCodecContext* codec, const AVCodecParameters* par),
           (codec, par))
FL_PASS_ON(kCodec, int, avcodec_receive_frame, (AVCodecContext* avctx, AVFrame* frame), (avctx, frame))
FL_PASS_ON(kCodec, int, avcodec_receive_packet, (AVCodecContext* avctx, AVPacket* avpkt), (avctx, avpkt))
FL_PASS_ON(kCodec, int, avcodec_send_frame, (AVCodecContext* avctx, const AVFrame* frame), (avctx, frame))
FL_PASS_ON(kCodec, int, avcodec_send_packet, (AVCodecContext* avctx, const AVPacket* avpkt), (avctx, avpkt))

FL_PASS_ON(kFormat, int, av_find_best_stream,
           (AVFormatContext* ic, AVMediaType type, int wanted_stream_nb, int related_stream, const AVCodec**
            decoder_ret, int flags),
           (ic, type, wanted_stream_nb, related_stream, decoder_ret, flags))
FL_PASS_ON(kFormat, int, av_interleaved_write_frame, (AVFormatContext* s, AVPacket* pkt), (s, pkt))
FL_PASS_ON(kFormat, int, av_read_frame, (AVFormatContext* s, AVPacket* pkt), (s, pkt))
FL_PASS_ON(kFormat, int, av_seek_frame,
           (AVFormatContext* s, int stream_index, std::int64_t timestamp, int flags),
           (s, stream_index, timestamp, flags))
FL_PASS_ON(kFormat, int, av_write_trailer, (AVFormatContext* s), (s))
FL_PASS_ON(kFormat, int, avformat_alloc_output_context2,
           (AVFormatContext** ctx, const AVOutputFormat* oformat, const char* format_name, const char* filename),
           (ctx, oformat, format_name, filename))
FL_PASS_ON(kFormat, void, avformat_close_input, (AVFormatContext** s), (s))
FL_PASS_ON(kFormat, int, avformat_find_stream_info, (AVFormatContext* ic, AVDictionary** options), (ic, options))
FL_PASS_ON(kFormat, void, avformat_free_context, (AVFormatContext* s), (s))
FL_PASS_ON(kFormat, AVStream*, avformat_new_stream, (AVFormatContext* s, const AVCodec* c), (s, c))
FL_PASS_ON(kFormat, int, avformat_open_input,
           (AVFormatContext** ps, const char* url, const AVInputFormat* fmt, AVDictionary** options),
           (ps, url, fmt, options))
FL_PASS_ON(kFormat, int, avformat_write_header, (AVFormatContext* s, AVDictionary** options), (s, options))
FL_PASS_ON(kFormat, AVIOContext*, avio_alloc_context,
           (unsigned char* buffer, int buffer_size, int write_flag, void* opaque, int (*read_packet)(void*,
            std::uint8_t*, int), int (*write_packet)(void*, std::uint8_t*, int), std::int64_t (*seek)(void*,
            std::int64_t, int)),
           (buffer, buffer_size, write_flag, opaque, read_packet, write_packet, seek))
FL_PASS_ON(kFormat, int, avio_closep, (AVIOContext** s), (s))
FL_PASS_ON(kFormat, void, avio_context_free, (AVIOContext** s), (s))
FL_PASS_ON(kFormat, int, avio_open, (AVIOContext** s, const char* url, int flags), (s, url, flags))

FL_PASS_ON(kScale, void, sws_freeContext, (SwsContext* swsContext), (swsContext))
FL_PASS_ON(kScale, SwsContext*, sws_getCachedContext,
           (SwsContext* context, int srcW, int srcH, AVPixelFormat srcFormat, int dstW, int dstH, AVPixelFormat
            dstFormat, int flags, SwsFilter* srcFilter, SwsFilter* dstFilter, const double* param),
           (context, srcW, srcH, srcFormat, dstW, dstH, dstFormat, flags, srcFilter, dstFilter, param))
FL_PASS_ON(kScale, const int*, sws_getCoefficients, (int colorspace), (colorspace))
FL_PASS_ON(kScale, SwsContext*, sws_getContext,
           (int srcW, int srcH, AVPixelFormat srcFormat, int dstW, int dstH, AVPixelFormat dstFormat, int flags,
            SwsFilter* srcFilter, SwsFilter* dstFilter, const double* param),
           (srcW, srcH, srcFormat, dstW, dstH, dstFormat, flags, srcFilter, dstFilter, param))
FL_PASS_ON(kScale, int, sws_scale,
           (SwsContext* c, const std::uint8_t* const srcSlice[], const int srcStride[], int srcSliceY, int srcSliceH,
            std::uint8_t* const dst[], const int dstStride[]),
           (c, srcSlice, srcStride, srcSliceY, srcSliceH, dst, dstStride))
FL_PASS_ON(kScale, int, sws_setColorspaceDetails,
           (SwsContext* c, const int inv_table[4], int srcRange, const int table[4], int dstRange, int brightness, int
            contrast, int saturation),
           (c, inv_table, srcRange, table, dstRange, brightness, contrast, saturation))
}
// clang-format on
// NOLINTEND(readability-identifier-naming)

#undef FL_PASS_ON
