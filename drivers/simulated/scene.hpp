#pragma once
// Scene: all true parameters of a simulated bench, which a measurement on it should find.
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/simulated/faults.hpp"
#include "drivers/simulated/shaker_truth.hpp"
#include "drivers/view.hpp"
#include "drivers/walker/friction.hpp"

namespace shaker::simulated {

struct WalkerTruth {
    double mass_kg = 0.06;
    double diameter_mm = 30;
    double height_mm = 12;
    double mu_k = 0.113;
    double mu_s = 0.113;
    double start_mm = -40;  // initial position on the shaker's axis; 0 is the middle of the base
    // Beyond dry friction; Friction has the equations. The defaults have no effect.
    walker::FrictionLaw law = walker::FrictionLaw::coulomb;  // not lugre
    double viscous_per_s = 0;
    double backward_ratio = 1;  // mu of backward slip over mu of forward slip
    double log_share = 0.1;     // law logarithmic
    double log_velocity_mps = 1e-3;
    double dahl_um = 7.2;        // presliding length of law dahl
    double stribeck_mps = 5e-3;  // velocity over which law stribeck falls from mu_s to mu_k
    double mu_jitter = 0;        // standard deviation as a share of mu, redrawn every mu_step_s
    double mu_memory = 0;        // correlation of one draw with the one before
    double mu_step_s = 0.05;     // a period of 20 Hz
    double mu_relaxation = 0;    // excess of mu at the start, as a share
    double relaxation_s = 10;
    double ageing = 0;  // growth of mu_s per factor e of the time at rest, as a share
    double ageing_s = 1e-3;
    double roughness = 0;     // rms of mu along the base, as a share
    double roughness_mm = 5;  // its wavelength
};

struct AccelerometerTruth {
    double rate_hz = 4000;               // nominal
    double clock_ppm = 37.5;             // error of its clock; positive: fast
    double clock_drift_ppm_per_min = 0;  // change of that error
    double clock_walk_us_rts = 0;        // random walk of that clock, us per square root of s
    double start_s = 0.0031;             // time of its tick 0 after the DAC's first write
    double lowpass_hz = 1000;            // second order, Butterworth
    int axes = 3;                        // as AccelerometerInfo
    int gravity = 1;                     // 0: not in the reading
    double high_pass_hz = 0;             // corner of each pole of an AC-coupled sensor along x; 0: none
    int high_pass_order = 1;             // poles: of the sensor, and of its conditioner
    double told_high_pass_hz = -1;       // what its data sheet says, to a tenth; -1: nothing
    double told_low_pass_hz = 0;         // the same of lowpass_hz; 0: nothing
    double noise_mps2_rthz = 245e-6;     // 25 ug/rtHz
    double range_mps2 = 78.5;            // +-8 g
    int bits = 20;
    double yaw_deg = 2;         // mounting: rotation of the sensor's x about z against the shaker's axis
    int axis_told = 0;          // 1: info() gives the shaker's axis in sensor axes; 0: unknown
    double latency_s = 0.0008;  // shortest delay until a block is at the host
    double latency_jitter_s = 100e-6;  // mean of the exponential part of the delay
    int block_samples = 64;            // samples per delivered block
    double mains_hz = 50;              // frequency of the hum on all axes
    double mains_mps2 = 0;             // amplitude of the hum
    /// [i][k]: reading of axis i per acceleration along k, over the reported gain.
    std::array<std::array<double, 3>, 3> gain{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    std::array<double, 3> offset_mps2{};  // reading of the axis without acceleration
    std::string calibration{};            // calibration file, from the folder of the scene; empty: none
    std::string response{};              // file of its response; the caller's
    std::string attitudes{};              // names, in order, of those it is held in; empty: it is on the base
    double hold_s = 3, turn_s = 1;        // in each attitude; to the next one
    double held_within_deg = 1;           // rms about each axis
};

/// What the view of a camera does not tell; 0: as told. OpenCV's distortion with the focal length distance_mm
/// / mm_per_px, or the picture's width for a telecentric lens.
struct TrueOptics {
    double mm_per_px = 0, distance_mm = 0;
    double k1 = 0, k2 = 0;
    double tilt_x_deg = 0, tilt_y_deg = 0;  // as View::tilt_deg
    double turn_deg = 0;                    // of the shaker's axis in the picture, from image x towards y
};

struct CameraTruth {
    TrueOptics optics{};
    View view;                    // geometry and targets (regions are for the resting scene)
    int width = 0, height = 0;    // px
    int code_seed = 0;            // of the base's bars of irregular width; 0: regular bars or dots
    int region_off_px = 0;        // error of the walker's region along the picture's width
    double psf_px = 0.7;          // Gaussian sigma of the lens
    double noise_dn = 2;          // rms, grey levels of 255
    double light_gradient = 0.1;  // relative change of brightness from left to right, +-
    double latency_s = 0.0005;    // from the end of the exposure to the arrival at the host
    int own_clock = 0;          // 1: frames carry a stamp of the camera's clock instead of their master time
    double clock_ppm = 0;       // error of that clock; positive: fast
    int positions = 0;          // 1: frames carry positions of the targets instead of pixels
    std::string calibration{};  // calibration file, from the folder of the scene; empty: none
    std::string boards{};       // places of a calibration board, which the camera then shows (board_places())
    double board_s = 1;         // in each place
    bool side = false;          // true: views along y (silhouette); false: down z
};

struct Scene {
    std::uint64_t seed = 1;
    double gravity = 9.8;
    double tilt_deg = 0;  // positive: +x points downhill
    double dac_rate_hz = 48000;
    double dac_full_scale_v = 1;
    double dac_buffer_s = 0;     // latency from write() to the converter
    double dac_kept_s = 1;       // part of dac_buffer_s that a hard stop cannot take back
    double enable_before_s = 0;  // the amplifier is on when its enable tone has lasted so long; 0: always
    ShakerTruth shaker;
    WalkerTruth walker;
    AccelerometerTruth accelerometer;
    std::array<CameraTruth, 2> cameras;  // top, side
    std::vector<SceneFault> faults;
};

/// What the simulated cameras give: pictures, or the places of the targets. Positions cost a hundredth.
enum class Detail { pixels, positions };

/// The paper's bench: brass walker of 30 mm on glass, mu = 0.113, two cameras at 1000 frames/s. With
/// positions the pictures are 640 px wide, twice as wide as with pixels.
Scene paper_scene(Detail detail = Detail::pixels);

/// Friction of the scene's walker in SI units; its random numbers come from the scene's seed.
walker::Friction friction_of(const Scene& scene);

/// Reads a TOML file: paper_scene() with the changes of the file. Unknown keys, wrong types and values out of
/// range throw InputError with file, line, key, value and range.
Scene read_scene(const std::filesystem::path& file);
/// Reads the remaining tables of `root`; the caller may have read others before. standard: the scene that the
/// file changes.
Scene read_scene(SettingsTable& root, const Scene& standard = paper_scene());
Scene parse_scene(const std::string& toml, const std::string& file_name);

/// TOML that read_scene() reads back exactly. Stored in recordings.
std::string scene_text(const Scene& scene);

}  // namespace shaker::simulated
