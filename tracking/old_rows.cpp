#include "tracking/old_rows.hpp"

#include <algorithm>
#include <cstring>
#include <span>

#include "tracking/image/pixels.hpp"

namespace shaker::tracking {

namespace {

constexpr int most_sampled_rows = 48;              // that are looked at
constexpr double noisy_from = 8, most_noise = 16;  // pictures
constexpr double noisy_share = 0.75;               // of the rows

constexpr std::size_t pieces = 3;  // of a long row, that are looked at
constexpr int noise_every = 4;     // pictures, in which a row is looked at for noise that is well known

using Bytes = std::span<const std::byte>;

/// Calls `take` with the part of a row that is looked at: all of it, or pieces.
template <class Take>
void each_piece(Bytes row, std::size_t most, Take take) {
    if (row.size() <= most) return take(row);
    const std::size_t piece = most / pieces;
    for (std::size_t i = 0; i < pieces; ++i)
        take(row.subspan(i * (row.size() - piece) / (pieces - 1) / 2 * 2, piece));
}

std::uint64_t mixed(std::uint64_t sum, std::uint64_t word) noexcept {
    sum = (sum ^ word) * 0x9E3779B97F4A7C15U;
    return sum ^ sum >> 32U;
}

// Four sums at a time: a product waits for the one before.
std::uint64_t checksum_of(std::uint64_t sum, Bytes bytes) noexcept {
    constexpr std::size_t word = 8, at_once = 4;
    std::array<std::uint64_t, at_once> sums{sum, 1, 2, 3}, words{};
    std::size_t i = 0;
    for (; i + sizeof words <= bytes.size(); i += sizeof words) {
        std::memcpy(words.data(), &bytes[i], sizeof words);
        for (std::size_t k = 0; k < at_once; ++k) sums.at(k) = mixed(sums.at(k), words.at(k));
    }
    for (; i < bytes.size(); i += word) {
        words[0] = 0;
        std::memcpy(words.data(), &bytes[i], std::min(word, bytes.size() - i));
        sums[0] = mixed(sums[0], words[0]);
    }
    return mixed(mixed(sums[0], sums[1]), mixed(sums[2], sums[3]));
}

/// Noise changes many pixels, and neighbours in both directions; motion changes neighbours alike.
template <class T>
bool noise_between(Bytes before, Bytes now) {
    constexpr int fewest = 32;
    constexpr double changed_share = 0.2, opposite_share = 0.42;
    std::array<T, OldRows::row_bytes / sizeof(T)> one{}, two{};
    const std::size_t all = now.size() / sizeof(T);
    std::memcpy(one.data(), before.data(), all * sizeof(T));
    std::memcpy(two.data(), now.data(), all * sizeof(T));
    std::array<std::int32_t, OldRows::row_bytes / sizeof(T)> change{};
    for (std::size_t i = 0; i < all; ++i) change[i] = two[i] - one[i];
    int changed = all > 0 && change[0] != 0 ? 1 : 0, pairs = 0, opposite = 0;
    for (std::size_t i = 1; i < all; ++i) {
        changed += change[i] != 0;
        pairs += (change[i] != 0) & (change[i - 1] != 0);
        opposite += ((change[i] ^ change[i - 1]) < 0) & (change[i] != 0) & (change[i - 1] != 0);
    }
    return changed >= std::max<double>(fewest, changed_share * static_cast<double>(all)) &&
           opposite >= opposite_share * pairs;
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

void OldRows::learn_noise(Row& row, Bytes now) {
    if (row.kept) {
        const Bytes before = Bytes{row.newest}.first(now.size());
        const bool noise = bytes_ == 2 ? noise_between<std::uint16_t>(before, now)
                                       : noise_between<std::uint8_t>(before, now);
        row.noise = std::clamp(row.noise + (noise ? 1 : -0.5), 0.0, most_noise);
    }
    std::ranges::copy(now, row.newest.begin());
    row.kept = true;
}

bool OldRows::in(const ImageView& image) {
    if (image.width != width_ || image.height != height_ || image.bytes_per_pixel != bytes_) {
        width_ = image.width, height_ = image.height, bytes_ = image.bytes_per_pixel;
        rows_.assign(static_cast<std::size_t>(std::min(most_sampled_rows, height_)), {});
        sums_.assign(rows_.size(), 0);
    }
    const std::size_t count = rows_.size();
    const auto row_of = [&](std::size_t i) {
        const auto y = static_cast<int>((2 * i + 1) * static_cast<std::size_t>(height_) / (2 * count));
        return Bytes{image.row(y), static_cast<std::size_t>(width_ * bytes_)};
    };
    std::array<std::byte, row_bytes> bytes{};
    const auto copy_of = [&](std::size_t i) {
        auto* to = bytes.data();
        each_piece(row_of(i), row_bytes, [&](Bytes piece) { to = std::ranges::copy(piece, to).out; });
        return Bytes{bytes.data(), to};
    };
    std::size_t with_noise = 0;
    for (std::size_t i = 0; i < count; ++i) {
        if (i + 1 < count)
            each_piece(row_of(i + 1), row_bytes, [](Bytes piece) { request(piece.data(), piece.size()); });
        sums_[i] = 0;
        each_piece(row_of(i), row_bytes, [&](Bytes piece) { sums_[i] = checksum_of(sums_[i], piece); });
        Row& row = rows_[i];
        with_noise += row.noise >= noisy_from;
        if (std::ranges::find(row.sums, sums_[i]) != row.sums.end())
            row.flat = bytes_ == 2 ? is_flat<std::uint16_t>(copy_of(i)) : is_flat<std::uint8_t>(copy_of(i));
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
    turn_ = (turn_ + 1) % noise_every;
    for (std::size_t i = 0; i < count; ++i) {
        Row& row = rows_[i];
        const std::size_t turn = (i + turn_) % noise_every;  // 0: kept; 1: compared with that
        if (!noisy || turn < 2 || row.noise < most_noise)
            learn_noise(row, copy_of(i));
        else
            row.kept = false;
        row.sums.at(oldest_) = sums_[i];
    }
    oldest_ = (oldest_ + 1) % remembered;
    return old;
}

}  // namespace shaker::tracking
