#pragma once
// Iiod: an IIO daemon with one accelerometer and no hardware. libiio clients read over TCP what another
// thread pushes. Faults on command.
#include <cstdint>
#include <memory>
#include <span>

#include "tests/mock/iiod_device.hpp"

namespace shaker::mock {

/// Sample counts since the start. For a single client: pushed = dropped + unheard + served + overflowed +
/// unread, except samples in transit.
struct IiodCounts {
    std::uint64_t pushed = 0;
    std::uint64_t dropped = 0;     // on purpose
    std::uint64_t unheard = 0;     // no client had an open buffer
    std::uint64_t served = 0;      // sent, sum over clients
    std::uint64_t overflowed = 0;  // the FIFO of a client was full, sum over clients
    std::uint64_t unread = 0;  // left in a client's FIFO when its buffer was closed, or lost without a later
                               // sample to show the loss; sum over clients
    std::uint64_t connections = 0;  // accepted so far
};

/// Serves on 127.0.0.1 in its own thread from construction to destruction. All members: any thread. Faults
/// take effect between the samples pushed before and after the call.
class Iiod {
public:
    /// port 0: any free port. Throws DeviceError when the port is in use, InputError for an invalid
    /// description.
    explicit Iiod(IiodDescription description, std::uint16_t port = 0);
    ~Iiod();
    Iiod(const Iiod&) = delete;
    Iiod& operator=(const Iiod&) = delete;

    [[nodiscard]] std::uint16_t port() const noexcept;
    /// As last set by the client.
    [[nodiscard]] double rate_hz() const noexcept;
    [[nodiscard]] IiodCounts counts() const noexcept;

    /// Adds conversions in order of time. When more than a million wait for the server, further samples are
    /// counted as overflowed.
    void push(std::span<const IiodSample> samples);

    /// Sends nothing for this long, then everything that was due.
    void silence(double seconds);
    /// Repeats the last counts for this duration of samples; stamps continue.
    void freeze(double seconds);
    /// Loses the next samples pushed, before any FIFO.
    void drop(std::uint64_t samples);
    /// Disconnects all clients; they may reconnect at once.
    void disconnect();
    /// Ends every open buffer: its present or next READBUF is answered with this (-errno).
    void error(int error);
    /// Shifts the clock of the stamps by this; adds up.
    void shift_stamps(std::int64_t ns);
    /// Delays interrupts in bursts from now on: the stamps of a burst are crowded at its end, late by up to
    /// about this and never early. 0 ends it.
    void jitter_stamps(std::int64_t ns);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace shaker::mock
