#pragma once
// PictureClock: when each picture of a file was exposed.
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "drivers/footage/lab_session.hpp"
#include "drivers/footage/media.hpp"

namespace shaker::footage {

/// The sources, the first that there is:
/// - the table `times` of the description: one row a picture;
/// - stamps of the file that lie on a grid with whole gaps: the pictures are numbered by it, and the rate is
///   the stated one, else that of the grid;
/// - uneven stamps of the file: they are the times, unless their unit is more than half a step;
/// - the stated rate, else that of the file's header.
/// The rate of a header is never combined with gaps: a mean rate contains them already.
class PictureClock {
public:
    /// InputError with the file: no rate and no times; stamps that step back or repeat, with their number and
    /// the first place; uneven stamps beside a stated rate that is not near theirs.
    PictureClock(const LabCamera& camera, Media& media);

    struct Exposure {
        std::int64_t tick = 0;  // counts missing exposures
        double t_s = 0;         // master time of its middle
    };
    /// Of picture `number` of the file, which is the one after `given` others. InputError when `times` has no
    /// row for it.
    [[nodiscard]] Exposure exposure(std::int64_t number, std::int64_t given) const;
    [[nodiscard]] double rate_hz() const noexcept { return rate_hz_; }
    /// The times come from a table or from uneven stamps, not from a rate.
    [[nodiscard]] bool has_times() const noexcept { return !times_s_.empty(); }
    /// Rows of the table `times`; 0 without one.
    [[nodiscard]] std::size_t rows() const noexcept { return rows_; }
    /// Properties of the times that the user should know, one sentence each.
    [[nodiscard]] const std::vector<std::string>& notes() const noexcept { return notes_; }

private:
    void take_times(std::vector<double> times_s);
    void take(const Stamps& stamps, double header_hz);
    bool take_grid(const Stamps& stamps, double header_hz);
    void take_uneven(const Stamps& stamps);

    std::string file_;
    double stated_hz_ = 0, first_s_ = 0;  // of the description; 0: not stated
    double rate_hz_ = 0;
    std::size_t rows_ = 0;
    std::vector<double> times_s_;      // by number
    std::vector<std::int64_t> ticks_;  // by number; empty: the number itself
    std::vector<std::string> notes_;
};

}  // namespace shaker::footage
