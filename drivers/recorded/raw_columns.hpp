#pragma once
// Columns of the raw streams: each one's name, type, unit, meaning and member stand here, for writing,
// reading, exporting and FORMAT.md.
#include <algorithm>
#include <array>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>

#include "drivers/data.hpp"
#include "drivers/recorded/pictures/picture_record.hpp"
#include "drivers/synthesiser.hpp"

namespace shaker::recorded {

/// A column of a raw stream.
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

/// A block of accelerometer samples without the samples.
struct RawBlock {
    AccelTick first;
    HostTime arrived;
    Quality quality{};
    std::uint8_t size = 0;
};

/// A frame without its pixels and sightings.
struct RawFrame {
    CameraTick tick;
    HostTime arrived;
    std::optional<CameraStamp> stamp;
    std::optional<MasterTime> mid_exposure;
    Quality quality{};
    std::uint64_t picture = 0;  // number of the stored one
};

namespace raw {

inline constexpr const char* drive = "raw/drive";
inline constexpr const char* changes = "raw/drive/changes";
inline constexpr const char* accelerometer = "raw/accelerometer";
inline constexpr const char* cameras = "raw";
inline constexpr std::size_t axes = 3;
inline constexpr std::size_t sighting_values = 3;  // of one target
inline constexpr Allowed not_negative{.least = 0};

inline constexpr std::array plays{
    column<&PlayTime::tick>(drive, "play_tick", "1", "DAC sample at which a block starts"),
    column<&PlayTime::heard>(drive, "play_heard", "ns", "host time at which that sample left the converter"),
    column<&PlayTime::lost>(drive, "play_lost", "1", "samples before it during which the DAC was empty")};

/// One 64-bit half of a phase.
template <Turns DriveChange::*Member, bool Low>
constexpr auto half(const char* name, const char* meaning) {
    return RawColumnOf<DriveChange>{
        {changes, name, RawColumn::Type::uint64, "1", meaning},
        [](const DriveChange& c, std::byte* to) {
            const std::uint64_t word = Low ? low_word(c.*Member) : high_word(c.*Member);
            std::memcpy(to, &word, sizeof word);
        },
        [](DriveChange& c, const std::byte* from) {
            std::uint64_t word = 0;
            std::memcpy(&word, from, sizeof word);
            c.*Member = Low ? turns_of(high_word(c.*Member), word) : turns_of(word, low_word(c.*Member));
        }};
}

/// The real (0) or imaginary (1) parts of all harmonics.
template <std::size_t Part>
constexpr auto harmonics(const char* name, const char* meaning) {
    return RawColumnOf<DriveChange>{
        {changes, name, RawColumn::Type::float64, "V", meaning, max_harmonics},
        [](const DriveChange& c, std::byte* to) {
            for (const std::complex<double>& a : c.command.volts.a) {
                const double part = Part == 0 ? a.real() : a.imag();
                to = std::copy_n(reinterpret_cast<const std::byte*>(&part), sizeof part, to);
            }
        },
        [](DriveChange& c, const std::byte* from) {
            for (std::complex<double>& a : c.command.volts.a) {
                double part = 0;
                std::memcpy(&part, from, sizeof part);
                from += sizeof part;
                a = Part == 0 ? std::complex{part, a.imag()} : std::complex{a.real(), part};
            }
        }};
}

inline constexpr RawColumnOf<DriveChange>
    first_tick =
        column<&DriveChange::first>(changes, "first_tick", "1", "DAC sample at which the change starts"),
    ramp_samples =
        column<&DriveChange::ramp>(changes, "ramp_samples", "1",
                                   "length of the ramp from the previous drive; of a stop: above 0, a ramp "
                                   "under way stands still"),
    stop_samples = column<&DriveChange::stop>(changes, "stop_samples", "1",
                                              "length of a stop's ramp to zero; 0: not a stop", not_negative),
    taken_back = column<&DriveChange::taken_back>(
        changes, "taken_back", "1",
        "samples from first_tick on that a stop took back from the DAC: earlier rows that start at or "
        "after first_tick did not take effect",
        {.least = 0, .added_later = true}),
    frequency = column<&DriveChange::command, &DriveCommand::frequency>(changes, "frequency", "Hz",
                                                                        "commanded frequency"),
    harmonics_re = harmonics<0>("harmonics_re", "drive = Im sum a_q exp(i q w t): real parts of a_q"),
    harmonics_im = harmonics<1>("harmonics_im", "imaginary parts of a_q");
inline constexpr std::array drive_changes{
    first_tick,
    ramp_samples,
    stop_samples,
    taken_back,
    column<&DriveChange::command, &DriveCommand::ramp_periods>(
        changes, "ramp_periods", "1", "commanded length of the ramp in periods",
        {.least = 1, .most = std::numeric_limits<int>::max()}),
    half<&DriveChange::phase, false>("phase", "phase at first_tick in turns / 2^64"),
    half<&DriveChange::phase, true>("phase_low", "next 64 bits of the phase"),
    half<&DriveChange::step, false>("step", "phase step per sample in turns / 2^64"),
    half<&DriveChange::step, true>("step_low", "next 64 bits of the step"),
    column<&DriveChange::command, &DriveCommand::sequence>(changes, "sequence", "1", "number of the command"),
    frequency,
    harmonics_re,
    harmonics_im};

inline constexpr RawColumn counts{
    accelerometer, "counts", RawColumn::Type::int32, "count", "unchanged samples x, y, z, one row per sample",
    axes};
inline constexpr RawColumnOf<RawBlock> block_quality = column<&RawBlock::quality>(
                                           accelerometer, "block_quality", "1",
                                           "0: good; otherwise the sum of 1 after a gap, 2 clipped, 4 late"),
                                       block_size = column<&RawBlock::size>(
                                           accelerometer, "block_size", "1", "samples in the block",
                                           {.least = 0, .most = AccelBlock::capacity});
inline constexpr std::array blocks{
    column<&RawBlock::first>(accelerometer, "block_first", "1", "number of a block's first sample"),
    column<&RawBlock::arrived>(accelerometer, "block_arrived", "ns", "host time at which the block was read"),
    block_quality, block_size};

inline constexpr RawColumnOf<RawFrame> picture = column<&RawFrame::picture>(
    cameras, "picture", "1", "number in the pictures folder, from 1; 0: no picture");
inline constexpr std::array frames{
    column<&RawFrame::tick>(cameras, "tick", "1", "number of the exposure; missed exposures count"),
    column<&RawFrame::arrived>(cameras, "arrived", "ns", "host time at which the frame was read"),
    column<&RawFrame::stamp>(cameras, "stamp", "ns", "time of the camera's own clock; -2^63: no stamp"),
    column<&RawFrame::mid_exposure>(cameras, "mid_exposure", "s",
                                    "master time if the frame contains it, otherwise NaN"),
    column<&RawFrame::quality>(cameras, "quality", "1", "as block_quality"),
    picture};
inline constexpr RawColumn sightings{cameras,
                                     "sightings",
                                     RawColumn::Type::float64,
                                     "px",
                                     "x, y and standard error, for each target; NaN: not seen. Only of a "
                                     "camera that gives positions instead of "
                                     "pictures",
                                     sighting_values};

}  // namespace raw

}  // namespace shaker::recorded
