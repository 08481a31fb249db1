#pragma once
// Counts a camera's exposures, those included that never arrived. Pure; takes no memory.
#include <cstdint>
#include <optional>

#include "drivers/time.hpp"

namespace shaker {

/// What came with one picture.
struct ExposureSign {
    std::optional<std::uint64_t> id;   // the camera's frame id, where it counts
    std::optional<CameraStamp> stamp;  // its clock
    HostTime arrived;
};

/// One picture's place among the exposures.
struct ExposurePlace {
    CameraTick tick;
    std::int64_t missed = 0;  // exposures between the picture before and this one
    bool gap = false;  // something is missing before it, or its place is only known from the host's clock
    bool clock_jumped =
        false;  // the camera's clock was set meanwhile: stamps before and after do not compare
};

/// Both kinds of evidence are used: ids show what was lost on the way, time stamps show exposures that the
/// camera itself left out, and the larger number counts. A step of the stamps that the host's clock
/// contradicts by more than half a second is a step of the camera's clock, and only ids count.
class ExposureCounter {
public:
    /// Ids of GigE Vision 1 have 16 bits and go from 65535 to 1, with 0 meaning "no id"; wide ones count on.
    enum class Ids { wrap_at_65535, wide };
    /// period_ns: time between exposures; 0 when they follow no rate. pause_ns: with a trigger from outside a
    /// longer silence without a gap in the ids is a pause of the trigger, not a loss; 0 when the camera runs
    /// free and has no pauses.
    ExposureCounter(Ids ids, std::int64_t period_ns, std::int64_t pause_ns) noexcept
        : wide_{ids == Ids::wide}, period_ns_{period_ns}, pause_ns_{pause_ns} {}

    /// The camera was opened anew: its ids begin somewhere else, its clock perhaps too.
    void reopened() noexcept { reopened_ = true; }
    ExposurePlace next(const ExposureSign& sign) noexcept;

private:
    struct Last {
        ExposureSign sign;
        std::int64_t tick;
    };
    [[nodiscard]] std::int64_t id_step(const ExposureSign& sign) noexcept;
    [[nodiscard]] std::int64_t periods(std::int64_t ns) const noexcept;

    bool wide_;
    std::int64_t period_ns_;
    std::int64_t pause_ns_;
    bool reopened_ = false;
    std::optional<Last> last_;
};

}  // namespace shaker
