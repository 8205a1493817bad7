#include "sim/core/result.h"

namespace footlight {

const char* name_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kNotFound: return "not found";
    case ErrorCode::kPermission: return "permission denied";
    case ErrorCode::kDisconnected: return "disconnected";
    case ErrorCode::kTimeout: return "timed out";
    case ErrorCode::kProtocol: return "protocol error";
    case ErrorCode::kBadInput: return "bad input";
    case ErrorCode::kUnsupported: return "unsupported";
    case ErrorCode::kIo: return "input/output error";
  }
  return "unknown error";
}

}  // namespace footlight
