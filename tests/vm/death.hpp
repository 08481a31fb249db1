#pragma once
// What a kernel's PCM goes on to play when the process that drives it ends.
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
    Seconds sounds_on{};      // from the end to the last sample that is not zero, as captured
    double largest_step = 0;  // from sample to sample, over all that was captured, a share of full scale
    double drive_step = 0;    // the drive's own
    Seconds longest_pause{};  // between two listenings; 20 ms when nothing stood still
};

/// A process of its own drives the DAC of `settings` with two harmonics for `duration` and then ends; the
/// PCM `capture` (S32, two channels, same rate) hears it, before and long after. Throws DeviceError.
AfterDeath hear_a_death(const alsa::AlsaSettings& settings, const std::string& capture, Seconds duration,
                        End end);

}  // namespace shaker
