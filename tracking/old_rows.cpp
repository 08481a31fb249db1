#include "tracking/old_rows.hpp"

#include <algorithm>
#include <cstring>
#include <span>

namespace shaker::tracking {

namespace {

constexpr int most_sampled_rows = 48;              // that are looked at
constexpr double noisy_from = 8, most_noise = 16;  // pictures
constexpr double noisy_share = 0.75;               // of the rows

using Bytes = std::span<std::byte>;

/// The row, or three pieces of it. Returns how many bytes there are.
std::size_t copy_row(const std::byte* row, std::size_t bytes, Bytes to) {
    if (bytes <= to.size()) {
        std::memcpy(to.data(), row, bytes);
        return bytes;
    }
    constexpr std::size_t pieces = 3;
    const std::size_t piece = to.size() / pieces;
    for (std::size_t i = 0; i < pieces; ++i)
        std::memcpy(&to[i * piece], row + i * (bytes - piece) / (pieces - 1) / 2 * 2, piece);
    return pieces * piece;
}

std::uint64_t checksum_of(Bytes row) {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < row.size(); i += 8) {
        std::uint64_t word = 0;
        std::memcpy(&word, &row[i], std::min<std::size_t>(8, row.size() - i));
        sum = (sum ^ word) * 0x9E3779B97F4A7C15U;
        sum ^= sum >> 32U;
    }
    return sum;
}

/// Noise changes many pixels, and neighbours in both directions; motion changes neighbours alike.
template <class T>
bool noise_between(Bytes before, Bytes now) {
    constexpr int fewest = 32;
    constexpr double changed_share = 0.2, opposite_share = 0.42;
    int all = 0, changed = 0, pairs = 0, opposite = 0, last = 0;
    for (std::size_t i = 0; i + sizeof(T) <= now.size(); i += sizeof(T), ++all) {
        T one{}, two{};
        std::memcpy(&one, &before[i], sizeof one);
        std::memcpy(&two, &now[i], sizeof two);
        const int change = two - one;
        changed += change != 0;
        pairs += change != 0 && last != 0;
        opposite += (change > 0 && last < 0) || (change < 0 && last > 0);
        last = change;
    }
    return changed >= std::max<double>(fewest, changed_share * all) && opposite >= opposite_share * pairs;
}

/// Fewer than a tenth of the neighbours differ: clipped, or black. Such rows are equal without being old.
template <class T>
bool is_flat(Bytes row) {
    constexpr double differing_share = 0.1;
    int all = 0, differ = 0;
    T last{};
    for (std::size_t i = 0; i + sizeof(T) <= row.size(); i += sizeof(T), ++all) {
        T one{};
        std::memcpy(&one, &row[i], sizeof one);
        differ += all > 0 && one != last;
        last = one;
    }
    return differ < differing_share * all;
}

}  // namespace

// A single row of blocks of a compressed movie may be equal to an earlier one at random.
bool OldRows::old_from(std::size_t picture, int height) const {
    constexpr int two_blocks = 17;  // px
    const auto count = static_cast<int>(rows_.size());
    const auto tells = [](const Row& row) { return row.noise >= noisy_from && !row.flat; };
    int equal = 0;  // all of them are in the run of a torn picture; a compressed movie has others
    for (std::size_t i = 0; i < rows_.size(); ++i)
        equal += rows_[i].same_as(sums_[i], picture) && tells(rows_[i]);
    const auto length = [&](int from, int step) {
        int n = 0, with_noise = 0;
        for (int i = from; i >= 0 && i < count; i += step, ++n) {
            const Row& row = rows_[static_cast<std::size_t>(i)];
            if (!row.same_as(sums_[static_cast<std::size_t>(i)], picture)) break;
            with_noise += tells(row);
        }
        return with_noise >= std::min(2, count) && with_noise == equal ? n : 0;
    };
    const double least = std::max(std::min<double>(two_blocks, height / 3.0), height / 8.0) * count / height;
    return std::max(length(0, 1), length(count - 1, -1)) >= least;
}

bool OldRows::in(const ImageView& image) {
    if (image.width != width_ || image.height != height_ || image.bytes_per_pixel != bytes_) {
        width_ = image.width, height_ = image.height, bytes_ = image.bytes_per_pixel;
        rows_.assign(static_cast<std::size_t>(std::min(most_sampled_rows, height_)), {});
        sums_.assign(rows_.size(), 0);
    }
    const std::size_t count = rows_.size();
    std::array<std::byte, row_bytes> bytes{};
    const auto row_of = [&](std::size_t i) {
        const auto y = static_cast<int>((2 * i + 1) * static_cast<std::size_t>(height_) / (2 * count));
        return Bytes{bytes}.first(copy_row(image.row(y), static_cast<std::size_t>(width_ * bytes_), bytes));
    };
    std::size_t with_noise = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const Bytes now = row_of(i);
        sums_[i] = checksum_of(now);
        rows_[i].flat = bytes_ == 2 ? is_flat<std::uint16_t>(now) : is_flat<std::uint8_t>(now);
        with_noise += rows_[i].noise >= noisy_from;
    }
    const bool noisy = static_cast<double>(with_noise) >= noisy_share * static_cast<double>(count);
    noise_seen_ = noise_seen_ || noisy;
    bool old = false, whole = false;
    for (std::size_t picture = 0; picture < remembered; ++picture) {
        old = old || (noisy && old_from(picture, height_));
        std::size_t same = 0;
        for (std::size_t i = 0; i < count; ++i) same += rows_[i].same_as(sums_[i], picture);
        whole = whole || same == count;
    }
    if (whole) return old;  // says nothing about noise, and is remembered already
    for (std::size_t i = 0; i < count; ++i) {
        Row& row = rows_[i];
        const Bytes now = row_of(i), before = Bytes{row.newest}.first(now.size());
        const bool noise = bytes_ == 2 ? noise_between<std::uint16_t>(before, now)
                                       : noise_between<std::uint8_t>(before, now);
        row.noise = std::clamp(row.noise + (noise ? 1 : -0.5), 0.0, most_noise);
        row.newest = bytes;
        row.sums.at(oldest_) = sums_[i];
    }
    oldest_ = (oldest_ + 1) % remembered;
    return old;
}

}  // namespace shaker::tracking
