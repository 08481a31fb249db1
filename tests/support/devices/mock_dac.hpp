#pragma once
// A mock converter with its libasound configuration and its output so far.
#include <cstdint>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "drivers/hardware/alsa/settings.hpp"
#include "drivers/time.hpp"
#include "tests/mock/converter.hpp"

namespace shaker::test {

/// A converter in a memory folder, with its configuration and settings. The rate is 48 kHz. Default settings:
/// 10 ms periods in a buffer of 200 ms, longer than the stalls of test machines.
class MockDac {
public:
    explicit MockDac(double ppm = 0, const std::filesystem::path& log = {});
    MockDac(const MockDac&) = delete;
    MockDac& operator=(const MockDac&) = delete;
    ~MockDac();

    /// A folder that is removed with this object.
    std::filesystem::path folder;
    alsa::AlsaSettings settings;
    mock::Converter converter;

    /// Reads all samples that are due. Afterwards the vectors hold every code of the three channels since
    /// timeline sample 0, left-justified.
    void listen();
    std::vector<std::int64_t> first, second, third;
    /// Reads the output for this duration.
    void listen_for(Seconds duration);
    /// The first sample at or after `from` with a non-zero drive; the end if there is none.
    [[nodiscard]] std::size_t next_sound(std::size_t from) const;
    /// The last sample with a non-zero drive, plus one.
    [[nodiscard]] std::size_t end_of_sound() const;
    /// Largest step between consecutive samples of the drive in [from, until), share of full scale.
    [[nodiscard]] double largest_step(std::size_t from, std::size_t until) const;
};

/// Two harmonics of 0.3 V, f = 100 Hz, at a tick of a 48 kHz DAC. Starts at zero.
double test_drive(std::int64_t tick);
/// Its steepest step from sample to sample, V.
constexpr double steepest_step = 2 * std::numbers::pi * 0.3 * (100 + 200) / 48000;
/// `n` samples of that drive from `tick` on.
std::vector<double> test_block(std::int64_t tick, std::size_t n);

}  // namespace shaker::test
