#pragma once
// Output of a kernel's PCM after the end of the process that drives it.
#include <cstdint>
#include <string>

#include "drivers/hardware/alsa/settings.hpp"
#include "drivers/time.hpp"

namespace shaker {

/// How the process ends.
enum class End {
    killed,   // by SIGKILL: the kernel closes its descriptors
    stopped,  // by SIGSTOP: they stay open
};

struct AfterDeath {
    double level = 0;         // largest sample before the end, a share of full scale
    Seconds sounds_on{};      // from the end of the process to the last captured sample that is not zero
    double largest_step = 0;  // largest step between captured samples, share of full scale
    double drive_step = 0;    // largest step of the drive itself
    Seconds longest_pause{};  // between two reads of the capture; 20 ms without a stall
};

/// A separate process drives the DAC of `settings` with two harmonics for `duration` and then ends. The PCM
/// `capture` (S32, two channels, same rate) records before and long after the end. Throws DeviceError.
AfterDeath hear_a_death(const alsa::AlsaSettings& settings, const std::string& capture, Seconds duration,
                        End end);

}  // namespace shaker
