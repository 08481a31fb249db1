#pragma once
// MockBench: all mock devices on one simulated shaker. The client's drive moves a simulated base, the walker
// slips on it, and accelerometer and two cameras observe it. Real time, real protocols, no hardware.
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "drivers/simulated/scene.hpp"
#include "tests/mock/converter.hpp"
#include "tests/mock/gige_camera.hpp"
#include "tests/mock/iiod.hpp"
#include "tests/mock/sound/line_input.hpp"
#include "tests/mock/sound/mixer.hpp"

namespace shaker::mock {

struct MockBenchSettings {
    simulated::Scene scene = simulated::paper_scene();
    /// Existing folder for the converter, libasound's configuration and the rig file.
    std::filesystem::path folder;
    std::filesystem::path plugin;  // shaker_mock_pcm.so
    double dac_ppm = 0;            // error of the DAC's clock against the host's; positive: fast
    std::array<double, 2> camera_ppm{-12, 23};
    std::uint16_t iiod_port = 0;  // 0: any free port
    /// The accelerometer is analog, on the input of the converter's card: two channels at the scene's
    /// accelerometer.rate_hz, 100 mV/g.
    bool line_input = false;
    /// With line_input: volts of the output over volts at the input, by a cable in place of shaker and
    /// sensor; 0: none.
    double cable = 0;
    int channels = 0;          // the card has so many outputs and inputs; 0: as many as are asked for
    bool commissioned = true;  // write a record for the rig file, so that a service drives it
    bool log_codes = false;    // write every output sample to the file "codes" in the folder (see Converter)
};

/// Addresses of the cameras (see loopback.hpp).
inline constexpr std::array<const char*, 2> bench_addresses{"127.0.0.1", "127.0.0.2"};

/// Runs in its own threads from construction to destruction. All members: any thread. Faults are set at the
/// devices.
class MockBench {
public:
    /// Throws DeviceError when an address, a port or a file is not available.
    explicit MockBench(const MockBenchSettings& settings);
    ~MockBench();
    MockBench(const MockBench&) = delete;
    MockBench& operator=(const MockBench&) = delete;

    /// Rig file with all devices, the shaker's data sheet and the targets.
    [[nodiscard]] const std::filesystem::path& rig_file() const noexcept;
    [[nodiscard]] Converter& dac() noexcept;
    /// Throws InputError where the bench has the other one.
    [[nodiscard]] Iiod& accelerometer();
    [[nodiscard]] LineInput& line_input();
    [[nodiscard]] bool has_line_input() const noexcept;
    [[nodiscard]] MockMixer& mixer() noexcept;
    /// name: as in the scene ("top", "side"). Throws InputError.
    [[nodiscard]] GigeCamera& camera(const std::string& name);
    [[nodiscard]] std::vector<std::string> camera_names() const;
    /// Number of trigger pulses missing between two others less than 1 s apart: underruns of the DAC.
    [[nodiscard]] std::uint64_t pulses_left_out() const;
    /// True drift velocity of the walker, m/s, between two times (s) after the first trigger pulse of a
    /// stream; streams count from 1. NaN if no camera recorded it.
    [[nodiscard]] double drift(std::uint64_t stream, double from_s, double to_s, double frequency_hz) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace shaker::mock
