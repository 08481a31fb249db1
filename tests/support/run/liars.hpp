#pragma once
// Whole runs in virtual time on a bench with one instrument that lies, judged by the true motion of its base.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/safety/trip.hpp"
#include "drivers/drive.hpp"

namespace shaker::test {

/// A bench with one wrong instrument, as changes to the scene.
struct Liar {
    std::string name, scene;
    /// Sensor: reading over truth; camera: true scale over stated scale; negative: wrong sign.
    double size = 1;

    /// Close enough to the truth that the run must be completed, or so far that it must not. Between both it
    /// may: the motion is near its limit, or the ratio near 0.8 or 1.25.
    [[nodiscard]] bool must_measure() const { return size > 0.88 && size < 1.2; }
    [[nodiscard]] bool must_stop() const { return size < 0.77 || size > 1.3; }
};

/// Each instrument wrong by 0.25 to 4, by its sign, by its axis.
std::vector<Liar> liars();
/// Instrument and size drawn by a seed: from 0.25 to 4, or with the wrong sign.
Liar drawn_liar(unsigned seed);

struct Judged {
    std::optional<safety::Trip> trip;
    std::string note;       // of the stop, by the instruments
    double asked_mm = 0;    // peak of the base's displacement that was ordered
    double limit_mm = 0;    // displacement_abort_mm
    double largest_mm = 0;  // half of the largest true range in a period of the drive
    double beyond_s = 0;    // time with a true motion above 1.25 times the limit
    bool measured = false;  // a result was reached
};

/// An honest bench with a drive and frame rates drawn by a seed: 5 to 60 Hz, 0.1 to 1.5 g, 100 to 1000
/// pictures a second.
struct Honest {
    Liar liar;
    Drive drive;
};
Honest drawn_honest(unsigned seed);

/// A drive, by default the paper's, whose displacement is 1/1.2 of its limit, in this folder. identify: the
/// response is measured first.
Judged judge(const Liar& liar, const std::filesystem::path& folder, bool identify = true,
             const Drive& drive = {});

}  // namespace shaker::test
