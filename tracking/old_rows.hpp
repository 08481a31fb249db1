#pragma once
// OldRows: finds pictures that are delivered twice, and torn ones.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/data.hpp"

namespace shaker::tracking {

/// Compares rows of a picture with the same rows of the four before it. Where there is noise, which changes a
/// fifth of the pixels or more and neighbours in both directions, equal rows are old. Where a quarter of the
/// rows has none (a movie that is compressed, a camera without noise, a covered lens, a picture narrower than
/// 32 px), nothing is called old.
class OldRows {
public:
    /// Takes the next picture: true when it is an earlier one, or when the rows from its first or to its last
    /// one, an eighth of it or more, are those of an earlier one. Allocates when the size has changed.
    bool in(const ImageView& image);
    /// Whether three quarters of the rows had noise once.
    [[nodiscard]] bool noise_seen() const noexcept { return noise_seen_; }
    static constexpr std::size_t row_bytes = 192;  // of a row, that are looked at

private:
    static constexpr int remembered = 4;  // pictures
    struct Row {
        std::array<std::byte, row_bytes> newest{};  // what is looked at of the row, in the newest picture,
        bool kept = false;                          // if it was kept
        std::array<std::uint64_t, remembered> sums{};
        bool flat = true;  // in the newest picture, if that is equal to an earlier one
        double noise = 0;  // grows with each look that finds noise in the row, else falls by half of that
        bool same_as(std::uint64_t sum, std::size_t picture) const { return sums.at(picture) == sum; }
    };
    void learn_noise(Row& row, std::span<const std::byte> now);
    [[nodiscard]] bool old_from(std::size_t picture, int height) const;

    std::vector<Row> rows_;
    std::vector<std::uint64_t> sums_;  // of the rows of the newest picture
    bool noise_seen_ = false;
    int width_ = 0, height_ = 0, bytes_ = 0;
    std::size_t oldest_ = 0, turn_ = 0;
};

}  // namespace shaker::tracking
