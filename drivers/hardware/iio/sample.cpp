#include "drivers/hardware/iio/sample.hpp"

#include <algorithm>

namespace shaker::iio {
namespace {

struct Member {
    long index;
    std::size_t size;
    std::size_t* offset;
};

constexpr std::size_t aligned(std::size_t offset, std::size_t size) noexcept {
    return (offset + size - 1) / size * size;
}

}  // namespace

IioScan lay_out_scan(std::span<const IioChannel> axes, const std::optional<IioChannel>& stamp) noexcept {
    IioScan scan;
    scan.used = axes.size();
    std::array<Member, 4> members{};
    std::size_t count = 0;
    const auto add = [&](const IioChannel& channel, IioField& field) {
        field.format = channel.format;
        members[count++] = {channel.index, channel.format.storage_bits / 8, &field.offset};
    };
    for (std::size_t k = 0; k < axes.size(); ++k) add(axes[k], scan.axes[k]);
    if (stamp) add(*stamp, scan.stamp.emplace());
    std::stable_sort(members.begin(), members.begin() + static_cast<std::ptrdiff_t>(count),
                     [](const Member& a, const Member& b) { return a.index < b.index; });
    std::size_t largest = 1;
    for (std::size_t i = 0; i < count; ++i) {
        const Member& member = members[i];
        largest = std::max(largest, member.size);
        if (i > 0 && member.index == members[i - 1].index) {
            *member.offset = *members[i - 1].offset;
            continue;
        }
        *member.offset = aligned(scan.size, member.size);
        scan.size = *member.offset + member.size;
    }
    scan.size = aligned(scan.size, largest);
    return scan;
}

bool fits_counts(const IioFormat& format) noexcept {
    return format.bits >= 1 && format.bits <= (format.is_signed ? 32U : 31U) &&
           format.bits + format.shift <= format.storage_bits;
}

std::array<std::int64_t, 2> limits_of(const IioFormat& format) noexcept {
    const std::int64_t span = std::int64_t{1} << (format.bits - (format.is_signed ? 1 : 0));
    return {format.is_signed ? -span : 0, span - 1};
}

std::int64_t unpack(std::span<const std::byte> sample, const IioField& field) noexcept {
    const IioFormat& format = field.format;
    const std::span bytes = sample.subspan(field.offset, format.storage_bits / 8);
    std::uint64_t word = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        const std::size_t place = format.big_endian ? bytes.size() - 1 - i : i;
        word |= std::to_integer<std::uint64_t>(bytes[i]) << (8 * place);
    }
    const unsigned above = 64 - format.bits;
    word = word >> format.shift << above;
    return format.is_signed ? static_cast<std::int64_t>(word) >> above
                            : static_cast<std::int64_t>(word >> above);
}

}  // namespace shaker::iio
