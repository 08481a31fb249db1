#pragma once
// ContactInput: a normally closed contact between a line and ground or supply.
#include <memory>

#include "drivers/devices.hpp"
#include "drivers/hardware/gpio/lines.hpp"

namespace shaker::gpio {

/// An edge ends the wait; without edges the level is read every read_s. An opening between two readings is
/// reported.
class ContactInput final : public AbortInput {
public:
    ContactInput(std::unique_ptr<InputLine> line, const AbortSettings& settings);
    [[nodiscard]] Contact read(std::chrono::milliseconds wait) noexcept override;

private:
    std::unique_ptr<InputLine> line_;
    AbortSettings settings_;
    bool readable_ = true;
};

}  // namespace shaker::gpio
