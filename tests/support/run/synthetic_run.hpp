#pragma once
// Runs with known truth as input of a reduction.
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "daemon/reduction/measurement.hpp"
#include "drivers/drive.hpp"
#include "drivers/response/sensor_response.hpp"
#include "drivers/walker/friction.hpp"

namespace shaker {

/// A settled Coulomb walker that never sticks (mu 0.113, phi 0, at least 1 g) on a biharmonic base with a
/// small third harmonic, seen at mid-exposure by perfect cameras plus noise.
struct SyntheticRun {
    Drive drive{20.0, 1.5 * paper_g, 0.5, 0.0};
    bool may_stick = false;                      // any drive, by small steps: v_D to 1e-4 of gamma/omega
    std::optional<walker::Friction> friction{};  // any law, by integration, on any drive; else mu 0.113
    double third = 0.0;                          // third harmonic of a_B, m/s^2
    int periods = 40;
    double frame_rate_hz = 1000;
    double exposure_s = 0;  // positions are means over it
    int views = 1;
    double position_noise_m = 2e-6;
    double noise_memory = 0;   // AR(1) coefficient from frame to frame
    double drift_jitter = 0;   // relative, standard deviation of D from period to period
    double drift_memory = 0;   // AR(1) coefficient of that from period to period
    double settling = 0;       // extra D in the first period, relative, ...
    double contraction = 0.7;  // ... shrinking by this each period
    double accel_rate_hz = 4000;
    double accel_noise_mps2 = 1.1e-3;
    LowerCorner corner{};   // of the accelerometer, which tells nothing of it
    double lowpass_hz = 0;  // of the accelerometer, two Butterworth poles; 0: none
    double late_s = 0.0123;
    double ppm = 20;
    double track_scale = 1;                                  // the cameras' scale error
    std::array<double, 3> axis{0.99939083, -0.03489950, 0};  // unit; sensor yawed by 2 degrees
    double start_s = 0.00015;                                // first mid-exposure
    std::uint64_t seed = 1;
};

/// Drift velocity of that walker, m/s.
double drift_velocity(const SyntheticRun& run);
/// Its velocity at phases i/n, m/s, for a run with `friction`.
std::vector<double> true_velocity(const SyntheticRun& run, int n);
reduction::Measurement make_measurement(const SyntheticRun& run);

/// The session "lab-session" of the shared data: exact positions plus noise, and the file of the
/// accelerometer. Empty if the folder is missing.
struct WrittenSession {
    reduction::Measurement measurement;
    double v_D, gamma, phi, late_s, ppm, efficiency;
    double stick_from, stick_to;  // units of T
};
std::optional<WrittenSession> lab_session(double position_noise_m, std::uint64_t seed);

}  // namespace shaker
