#include "drivers/ports_factory.h"

#include <algorithm>

namespace footlight::drivers {
namespace {

Result<const DriverInfo*> driver_of(const PortRequest& request) {
  if (const DriverInfo* driver = find_driver(request.scheme)) return driver;
  std::string known;
  for (const DriverInfo* driver : drivers()) known += fmt::format("{}{}", known.empty() ? "" : ", ", driver->id);
  return fail(ErrorCode::kBadInput, "{}:{}: no driver of that name; there are {}", request.scheme, request.target,
              known);
}

Status check_universes(const PortRequest& request) {
  for (const Universe universe : request.universes)
    if (!is_universe(universe))
      return fail(ErrorCode::kBadInput, "{}:{}: universe {}: expected {} to {}", request.scheme, request.target,
                  universe, kUniverseMin, kUniverseMax);
  return {};
}

}  // namespace

const DriverInfo* find_driver(std::string_view id) {
  const auto all = drivers();
  const auto found = std::find_if(all.begin(), all.end(), [&](const DriverInfo* driver) { return driver->id == id; });
  return found == all.end() ? nullptr : *found;
}

std::string name_of(const PortRequest& request) {
  if (!request.name.empty()) return request.name;
  return request.target.empty() ? request.scheme : fmt::format("{}:{}", request.scheme, request.target);
}

bool has_driver(std::string_view scheme) { return find_driver(scheme) != nullptr; }

Result<std::unique_ptr<Sink>> open_sink(const PortRequest& request, Clock& clock) {
  FL_ASSIGN(const DriverInfo* driver, driver_of(request));
  FL_TRY(check_universes(request));
  if (driver->open_sink == nullptr) return fail(ErrorCode::kUnsupported, "{}: has no output", name_of(request));
  return driver->open_sink(request, clock);
}

Result<std::unique_ptr<Source>> open_source(const PortRequest& request, Clock& clock) {
  FL_ASSIGN(const DriverInfo* driver, driver_of(request));
  FL_TRY(check_universes(request));
  if (driver->open_source == nullptr) return fail(ErrorCode::kUnsupported, "{}: has no input", name_of(request));
  return driver->open_source(request, clock);
}

}  // namespace footlight::drivers
