#pragma once
// A mock converter with libasound's configuration for it, and what it has put out so far.
#include <cstdint>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "drivers/hardware/alsa_settings.hpp"
#include "drivers/mock/converter.hpp"
#include "drivers/time.hpp"

namespace shaker::test {

/// A memory folder of its own with a converter, the configuration and settings that find it. The rate is
/// 48 kHz. Default settings: 10 ms periods in 200 ms, which no stall of this kind of machine empties.
class MockDac {
public:
    explicit MockDac(double ppm = 0, const std::filesystem::path& log = {});
    MockDac(const MockDac&) = delete;
    MockDac& operator=(const MockDac&) = delete;
    ~MockDac();

    /// A folder that goes when this goes.
    std::filesystem::path folder;
    AlsaSettings settings;
    Converter converter;

    /// Takes what is due. From then on `first` and `second` hold every code from timeline sample 0 on,
    /// left-justified.
    void listen();
    std::vector<std::int64_t> first, second;
    /// Listens for so long.
    void listen_for(Seconds duration);
    /// The first sample at or after `from` whose drive is not zero; the end when there is none.
    [[nodiscard]] std::size_t next_sound(std::size_t from) const;
    /// The last sample whose drive is not zero, plus one.
    [[nodiscard]] std::size_t end_of_sound() const;
    /// Largest step between neighbours of the drive in [from, until), as a share of full scale.
    [[nodiscard]] double largest_step(std::size_t from, std::size_t until) const;
};

/// Two harmonics of 0.3 V, f = 100 Hz, at a tick of a 48 kHz DAC. Begins at zero.
double test_drive(std::int64_t tick);
/// Its steepest step from sample to sample, V.
constexpr double steepest_step = 2 * std::numbers::pi * 0.3 * (100 + 200) / 48000;
/// `n` samples of it from `tick` on.
std::vector<double> test_block(std::int64_t tick, std::size_t n);

}  // namespace shaker::test
