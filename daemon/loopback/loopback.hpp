#pragma once
// A cable from the drive's output to the sensor's input: what both ends of a sound card do to a signal.
#include <functional>
#include <string>
#include <vector>

#include "calibration/estimate.hpp"
#include "drivers/devices.hpp"

namespace shaker::loopback {

/// Of input and output together. Full scale: the largest value of output and input.
struct Measured {
    calibration::Estimate gain{};     // m/s^2 of the sensor's reading per V of the output, at 100 Hz
    calibration::Estimate share{};    // share of the input's full scale per share of the output's, at 100 Hz
    calibration::Estimate delay_s{};  // of the input behind the output, by their stamps
    calibration::Estimate corner_hz{};  // of one pole that is coupled by a capacitor
    double noise = 0;                   // of the input at rest, rms, share of its full scale
    double distortion = 0;              // harmonics 2 to 5 of 100 Hz at a tenth of full scale, over the first
    double pulses = 0;                  // largest of the harmonics 1 to 5 of full pulses at 100 Hz in the
                                        // silent drive, as a share of a full drive
};

/// The sound card of a rig file: its [dac], and its [accelerometer] of the driver "alsa". `granted`: what the
/// devices said. InputError for another driver.
Rig open_sound(const std::string& rig_file, std::vector<std::string>& granted);

struct Operator {
    std::function<void(const std::string&)> say;
    std::function<void()> rethrow;  // throws when the operator has interrupted the program
};

/// Plays the drive's output and hears the accelerometer, an input of 2^31 counts full scale. Begins 60 dB
/// below full scale for 0.1 s and goes on only when the input has shown that, then 40 and 20 dB below, in
/// proportion and with low tones as loud as high ones: a shaker with a sensor is no cable. The enable output
/// stays off. About 14 s. DeviceError when the input does not show the output, when it shows no cable, and
/// when a device fails.
Measured measure(Rig& rig, const Operator& person);

/// A table, and the key for the rig file; ends with a newline. dac_full_scale_V: of the rig file.
std::string text(const Measured& m, double dac_full_scale_V);
/// {"gain_mps2_per_V", "share", "delay_s", "corner_hz" with "..._se"; "noise", "distortion", "pulses",
/// "full_scale_V" of the input}. Values that are not known are null.
std::string json(const Measured& m, double dac_full_scale_V);

}  // namespace shaker::loopback
