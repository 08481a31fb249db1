#pragma once
// Every truth of a simulated bench in one aggregate: what a measurement on it should find.
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>

#include "drivers/settings_table.hpp"
#include "drivers/view.hpp"

namespace shaker {

/// Electrodynamic shaker driven by a voltage amplifier. The default moving mass, stiffness, damping, R and Bl
/// are those of a B&K 4809 as published in maltekrack/NLtest; its inductance is an assumed 0.5 mH.
struct ShakerTruth {
    double moving_mass_kg = 0.057;
    double base_mass_kg = 0.5;    // table and slide, without the walker
    double stiffness_npm = 9932;  // N/m
    double damping_nspm = 21.5;   // N s/m
    double resistance_ohm = 2;
    double inductance_h = 0.5e-3;
    double force_factor_npa = 6.78;            // Bl
    double amplifier_gain = 10;                // volts out a volt in
    double amplifier_limit_v = 20;             // clips beyond
    std::array<double, 2> high_pass_hz{2, 3};  // AC coupling, two one-pole stages
};

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
    double start_s = 0.0031;          // true time of its tick 0
    double lowpass_hz = 1000;         // second order, Butterworth
    double noise_mps2_rthz = 245e-6;  // 25 ug/rtHz
    double range_mps2 = 78.5;         // +-8 g
    int bits = 20;
    double yaw_deg = 2;                // mounting: the sensor's x is turned about z against the shaker's axis
    double latency_s = 0.0008;         // least delay until a block is in the host's hands
    double latency_jitter_s = 100e-6;  // mean of the exponential part
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
    ShakerTruth shaker;
    WalkerTruth walker;
    AccelerometerTruth accelerometer;
    std::array<CameraTruth, 2> cameras;  // top, side
};

/// The bench of the paper: brass walker of 30 mm on glass, mu = 0.113, two cameras at 1000 frames a second.
Scene paper_scene();

/// A scene from a TOML file: paper_scene() with what the file changes. Unknown keys, wrong types and values
/// out of range are refused (InputError) with file, line, key, value and range.
Scene read_scene(const std::filesystem::path& file);
Scene parse_scene(const std::string& toml, const std::string& file_name);

/// The table [shaker] of a scene, which a rig file has too: the shaker's and the amplifier's data sheet.
ShakerTruth read_shaker(SettingsTable table);
std::string shaker_text(const ShakerTruth& shaker);

/// The same as TOML that read_scene() accepts, every number to the last digit: what a recording stores.
std::string scene_text(const Scene& scene);

}  // namespace shaker
