#pragma once
// RawColumnOf: a column of a raw stream and the member of a row that it stores. The table of columns is in
// raw_columns.hpp.
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>

#include "drivers/data.hpp"
#include "drivers/recorded/pictures/picture_record.hpp"

namespace shaker::recorded {

struct RawColumn {
    enum class Type { int32, int64, uint8, uint64, float64 };
    const char* group;  // under /entry; of a camera's column "raw"
    const char* name;
    Type type;
    const char* units;  // UDUNITS text
    const char* meaning;
    std::size_t values = 1;  // a row
    /// Range of an integer of 64 bits or of a byte; a file with other values is refused.
    std::int64_t least = std::numeric_limits<std::int64_t>::min(),
                 most = std::numeric_limits<std::int64_t>::max();
    bool added_later = false;  // older files are without it: the member keeps its default

    /// Of a row.
    [[nodiscard]] std::size_t bytes() const;
};

/// camera: of a camera's columns.
inline std::string path_of(const RawColumn& column, const std::string& camera = {}) {
    return std::string{column.group} + "/" + (camera.empty() ? camera : camera + "/") + column.name;
}

/// Calls f with a zero of the column's type.
decltype(auto) with_zero(RawColumn::Type type, auto f) {
    switch (type) {
        case RawColumn::Type::int32:
            return f(std::int32_t{});
        case RawColumn::Type::int64:
            return f(std::int64_t{});
        case RawColumn::Type::uint8:
            return f(std::uint8_t{});
        case RawColumn::Type::uint64:
            return f(std::uint64_t{});
        case RawColumn::Type::float64:
            break;
    }
    return f(double{});
}

inline std::size_t RawColumn::bytes() const {
    return values * with_zero(type, [](auto zero) { return sizeof zero; });
}

/// A column that stores a part of a Row. Values are in memory as in the file.
template <class Row>
struct RawColumnOf : RawColumn {
    void (*get)(const Row&, std::byte* values);
    void (*set)(Row&, const std::byte* values);
};

namespace raw {

// Numbers in a file for members, and back.
constexpr std::int64_t stored(std::int64_t n) { return n; }
constexpr std::int64_t stored(int n) { return n; }
constexpr std::uint64_t stored(std::uint64_t n) { return n; }
constexpr std::uint8_t stored(std::uint8_t n) { return n; }
constexpr double stored(double x) { return x; }
constexpr std::uint8_t stored(Quality q) { return static_cast<std::uint8_t>(q); }
template <class Clock>
constexpr std::int64_t stored(Tick<Clock> tick) {
    return tick.n;
}
constexpr std::int64_t stored(HostTime t) { return t.time_since_epoch().count(); }
constexpr std::int64_t stored(const std::optional<CameraStamp>& stamp) {
    return stamp ? stamp->n : pictures::no_stamp;
}
constexpr double stored(const std::optional<MasterTime>& t) {
    return t ? seconds(*t) : std::numeric_limits<double>::quiet_NaN();
}

template <class T, class Number>
constexpr void restore(T& member, Number n) {
    member = static_cast<T>(n);
}
template <class Clock>
constexpr void restore(Tick<Clock>& tick, std::int64_t n) {
    tick.n = n;
}
constexpr void restore(HostTime& t, std::int64_t ns) { t = HostTime{std::chrono::nanoseconds{ns}}; }
constexpr void restore(std::optional<CameraStamp>& stamp, std::int64_t n) {
    if (n != pictures::no_stamp) stamp = CameraStamp{n};
}
constexpr void restore(std::optional<MasterTime>& t, double s) {
    if (s == s) t = master_time(s);
}

template <class Number>
constexpr RawColumn::Type type_of() {
    if constexpr (std::same_as<Number, std::int64_t>)
        return RawColumn::Type::int64;
    else if constexpr (std::same_as<Number, std::uint64_t>)
        return RawColumn::Type::uint64;
    else if constexpr (std::same_as<Number, std::uint8_t>)
        return RawColumn::Type::uint8;
    else
        return RawColumn::Type::float64;
}

template <class Member>
struct ClassOf;
template <class Class, class Member>
struct ClassOf<Member Class::*> {
    using type = Class;
};

/// Range and age of a column.
struct Allowed {
    std::int64_t least = RawColumn{}.least, most = RawColumn{}.most;
    bool added_later = false;
};

/// Column of a member or of a member's member: column<&DriveChange::command, &DriveCommand::sequence>(...).
template <auto First, auto... Rest>
constexpr auto column(const char* group, const char* name, const char* units, const char* meaning,
                      Allowed allowed = {}) {
    using Row = typename ClassOf<decltype(First)>::type;
    using Number = decltype(stored(((std::declval<const Row&>().*First).*....*Rest)));
    return RawColumnOf<Row>{
        {group, name, type_of<Number>(), units, meaning, 1, allowed.least, allowed.most, allowed.added_later},
        [](const Row& row, std::byte* to) {
            const Number n = stored(((row.*First).*....*Rest));
            std::memcpy(to, &n, sizeof n);
        },
        [](Row& row, const std::byte* from) {
            Number n;
            std::memcpy(&n, from, sizeof n);
            restore(((row.*First).*....*Rest), n);
        }};
}

}  // namespace raw

}  // namespace shaker::recorded
