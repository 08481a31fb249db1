#pragma once
// Every truth of a simulated bench in one aggregate: what a measurement on it should find.
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/simulated/faults.hpp"
#include "drivers/simulated/shaker_truth.hpp"
#include "drivers/view.hpp"

namespace shaker {

struct WalkerTruth {
    double mass_kg = 0.06;
    double diameter_mm = 30;
    double height_mm = 12;
    double mu_k = 0.113;
    double mu_s = 0.113;
    double start_mm = -40;  // on the shaker's axis; 0 is the middle of the base
};

struct AccelerometerTruth {
    double rate_hz = 4000;            // nominal
    double clock_ppm = 37.5;          // its clock runs fast by this
    double start_s = 0.0031;          // its tick 0, after the DAC's first write
    double lowpass_hz = 1000;         // second order, Butterworth
    double noise_mps2_rthz = 245e-6;  // 25 ug/rtHz
    double range_mps2 = 78.5;         // +-8 g
    int bits = 20;
    double yaw_deg = 2;                // mounting: the sensor's x is turned about z against the shaker's axis
    int axis_told = 0;                 // 1: it is known where the shaker's axis lies in it
    double latency_s = 0.0008;         // least delay until a block is in the host's hands
    double latency_jitter_s = 100e-6;  // mean of the exponential part
    int block_samples = 64;            // handed on together
    double mains_hz = 50;              // hum picked up on all axes
    double mains_mps2 = 0;             // its amplitude
};

struct CameraTruth {
    View view;                    // geometry and what is in it (rois are for the resting scene)
    int width = 0, height = 0;    // px
    double psf_px = 0.7;          // Gaussian sigma of the lens
    double noise_dn = 2;          // rms, grey levels of 255
    double light_gradient = 0.1;  // brightness changes by +- this from left to right
    double latency_s = 0.0005;    // exposure end until the frame is in the host's hands
    bool side = false;            // looks along y (silhouette) instead of down z
};

struct Scene {
    std::uint64_t seed = 1;
    double gravity = 9.8;
    double tilt_deg = 0;  // base downhill towards +x
    double dac_rate_hz = 48000;
    double dac_full_scale_v = 1;
    double dac_buffer_s = 0;  // from a write until its first sample is heard
    ShakerTruth shaker;
    WalkerTruth walker;
    AccelerometerTruth accelerometer;
    std::array<CameraTruth, 2> cameras;  // top, side
    std::vector<SceneFault> faults;
};

/// The bench of the paper: brass walker of 30 mm on glass, mu = 0.113, two cameras at 1000 frames a second.
Scene paper_scene();

/// A scene from a TOML file: paper_scene() with what the file changes. Unknown keys, wrong types and values
/// out of range are refused (InputError) with file, line, key, value and range.
Scene read_scene(const std::filesystem::path& file);
/// From a table that may have had tables taken out of it before: what is left must be of a scene.
Scene read_scene(SettingsTable& root);
Scene parse_scene(const std::string& toml, const std::string& file_name);

/// The same as TOML that read_scene() accepts, every number to the last digit: what a recording stores.
std::string scene_text(const Scene& scene);

}  // namespace shaker
