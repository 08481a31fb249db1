#pragma once
// LineInput: the mock input of a sound card behind the PCM plug-in.
#include <array>
#include <cstdint>
#include <filesystem>
#include <span>

#include "drivers/time.hpp"

namespace shaker::mock {

struct LineMemory;

/// The owner's side. put(): one thread; all others: any thread.
class LineInput {
public:
    /// Creates `file`, which the plug-in maps, and removes it at the end. rate_hz: true rate of its clock,
    /// which the client sees as nominal_hz. Throws DeviceError when the file cannot be created.
    LineInput(const std::filesystem::path& file, double nominal_hz, double rate_hz, HostTime epoch);
    LineInput(const LineInput&) = delete;
    LineInput& operator=(const LineInput&) = delete;
    ~LineInput();

    /// The next samples of both channels, left-justified codes.
    void put(std::span<const std::array<std::int32_t, 2>> samples) noexcept;
    /// Stops the running stream, as after an overrun.
    void cause_overrun() noexcept;
    /// Removes the device for its client until plug().
    void unplug() noexcept;
    void plug() noexcept;

private:
    std::filesystem::path file_;
    LineMemory* memory_;
};

}  // namespace shaker::mock
