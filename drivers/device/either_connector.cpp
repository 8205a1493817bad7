#include "drivers/device/either_connector.h"

namespace footlight::drivers {
namespace {

class EitherConnector final : public Connector {
 public:
  EitherConnector(std::unique_ptr<Connector> first, std::unique_ptr<Connector> second)
      : first_(std::move(first)), second_(std::move(second)) {}

  Result<std::unique_ptr<Transport>> connect() override {
    auto transport = first_->connect();
    if (transport) return transport;
    const ErrorCode code = transport.error().code;
    if (code != ErrorCode::kPermission && code != ErrorCode::kUnsupported && code != ErrorCode::kNotFound)
      return transport;
    auto other = second_->connect();
    if (other) return other;
    return transport;  // says what mends the better way
  }
  void wait(TimeNs deadline_ns) override { first_->wait(deadline_ns); }
  void wake() override {
    first_->wake();
    second_->wake();
  }
  void abort() override {
    first_->abort();
    second_->abort();
  }
  std::string identity() override { return first_->identity(); }

 private:
  const std::unique_ptr<Connector> first_, second_;
};

}  // namespace

std::unique_ptr<Connector> make_either_connector(std::unique_ptr<Connector> first, std::unique_ptr<Connector> second) {
  return std::make_unique<EitherConnector>(std::move(first), std::move(second));
}

}  // namespace footlight::drivers
