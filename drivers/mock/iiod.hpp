#pragma once
// An IIO daemon with one accelerometer and no hardware: real libiio clients read from it over TCP what
// another thread pushes in. With faults on command.
#include <cstdint>
#include <memory>
#include <span>

#include "drivers/mock/iiod_device.hpp"

namespace shaker {

/// Samples since the start. Every pushed one ends in exactly one of the others, except those still under way:
/// pushed = dropped + unheard + (served + overflowed + unread) of a single client.
struct IiodCounts {
    std::uint64_t pushed = 0;
    std::uint64_t dropped = 0;     // on purpose
    std::uint64_t unheard = 0;     // no client had a buffer open
    std::uint64_t served = 0;      // sent, summed over clients
    std::uint64_t overflowed = 0;  // a client's FIFO was full, summed over clients
    std::uint64_t unread = 0;      // left in a client's FIFO when its buffer was closed, or lost with nothing
                                   // sent after it that could tell the client; likewise
    std::uint64_t connections = 0;  // accepted so far
};

/// Serves on 127.0.0.1 from its construction to its destruction, on a thread of its own. All members may be
/// called from any thread; faults take effect between the samples pushed before and after the call.
class Iiod {
public:
    /// Port 0: any that is free. Throws DeviceError when the port cannot be had, InputError for a description
    /// that means nothing.
    explicit Iiod(IiodDescription description, std::uint16_t port = 0);
    ~Iiod();
    Iiod(const Iiod&) = delete;
    Iiod& operator=(const Iiod&) = delete;

    [[nodiscard]] std::uint16_t port() const noexcept;
    /// As the client last set it.
    [[nodiscard]] double rate_hz() const noexcept;
    [[nodiscard]] IiodCounts counts() const noexcept;

    /// Conversions in the order of time. Samples beyond a million that the server has not got to are counted
    /// as overflowed.
    void push(std::span<const IiodSample> samples);

    /// Nothing is sent to anybody for this long; what was due is sent afterwards.
    void silence(double seconds);
    /// For this long, in samples, every sample repeats the last counts; stamps go on.
    void freeze(double seconds);
    /// The next samples pushed are lost before any FIFO.
    void drop(std::uint64_t samples);
    /// All clients are cut off; they may come back at once.
    void disconnect();
    /// Every open buffer ends: its next READBUF, or the one under way, is answered with this (-errno).
    void error(int error);
    /// The clock of the stamps jumps by this; again by 0 leaves it where it is.
    void shift_stamps(std::int64_t ns);
    /// From now on interrupts are served late in bursts: stamps of a burst are crowded together at its end,
    /// late by up to about this and never early. 0 ends it.
    void jitter_stamps(std::int64_t ns);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace shaker
