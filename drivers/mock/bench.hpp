#pragma once
// The mock devices as one bench: what a client plays moves a simulated base, the walker on it slips, and the
// accelerometer and two cameras see it. Real time, real protocols, no hardware.
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "drivers/mock/converter.hpp"
#include "drivers/mock/gige_camera.hpp"
#include "drivers/mock/iiod.hpp"
#include "drivers/simulated/scene.hpp"

namespace shaker {

struct BenchSettings {
    Scene scene = paper_scene();
    std::filesystem::path
        folder;  // an existing one, for the converter, libasound's configuration, the rig file
    std::filesystem::path plugin;  // shaker_mock_pcm.so
    double dac_ppm = 0;            // the DAC's clock runs fast by this against the host's
    std::array<double, 2> camera_ppm{-12, 23};
    std::uint16_t iiod_port = 0;  // 0: any that is free
    bool log_codes = false;       // every sample put out, into the folder's file "codes" (see Converter)
};

/// The addresses that the cameras need (see loopback.hpp).
inline constexpr std::array<const char*, 2> bench_addresses{"127.0.0.1", "127.0.0.2"};

/// The bench lives from construction to destruction, on threads of its own. Members may be called from any
/// thread; faults are caused at the devices themselves.
class Bench {
public:
    /// Throws DeviceError when an address, a port or a file cannot be had.
    explicit Bench(const BenchSettings& settings);
    ~Bench();
    Bench(const Bench&) = delete;
    Bench& operator=(const Bench&) = delete;

    /// Names all devices, with the shaker's data sheet and what the cameras see.
    [[nodiscard]] const std::filesystem::path& rig_file() const noexcept;
    [[nodiscard]] Converter& dac() noexcept;
    [[nodiscard]] Iiod& accelerometer() noexcept;
    /// By the scene's name ("top", "side"). Throws InputError.
    [[nodiscard]] GigeCamera& camera(const std::string& name);
    [[nodiscard]] std::vector<std::string> camera_names() const;
    /// Trigger pulses that should have been between two others less than 1 s apart: the DAC stood empty.
    [[nodiscard]] std::uint64_t pulses_left_out() const;
    /// The walker's true drift velocity, m/s, between two times after the first trigger pulse of a stream
    /// (s); streams are counted from 1 on. NaN where no camera has seen it.
    [[nodiscard]] double drift(std::uint64_t stream, double from_s, double to_s) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace shaker
