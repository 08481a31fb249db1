#pragma once
// IiodConnection: one client of the mock iiod. Answers its commands and streams its buffer, in the server's
// thread.
#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/mock/iiod_device.hpp"
#include "tests/mock/iiod_protocol.hpp"

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>

namespace shaker::mock {

/// State shared by all connections.
struct IiodShared {
    IiodDevice device;
    std::atomic<double> rate_hz{device.rate_hz()};  // for other threads
    bool silent = false;                            // nothing is sent: replies wait until the silence ends
    bool triggered = true;                          // a trigger is assigned to the device
    std::size_t buffers = 4;  // kernel buffers for the next client that opens the device: libiio sets them on
                              // a different connection from the one that opens it
    std::uint64_t timeout_ms = 1000;  // without samples until a READBUF fails; 0: none
    std::atomic<std::uint64_t> served{0}, overflowed{0}, unread{0};
};

class IiodConnection : public std::enable_shared_from_this<IiodConnection> {
public:
    IiodConnection(boost::asio::ip::tcp::socket socket, IiodShared& shared);

    void start() { receive(); }
    [[nodiscard]] bool buffer_open() const noexcept { return buffer_.has_value(); }
    [[nodiscard]] bool closed() const noexcept { return !socket_.is_open(); }
    /// Adds a conversion to the buffer's FIFO; serve() sends what is due.
    void offer(const IiodSample& sample);
    void serve();
    /// Ends the buffer: its present or next READBUF is answered with -errno.
    void fail(int error);
    /// Call at the end of a silence.
    void flush() { send(); }
    void close();

private:
    struct Held {
        IiodSample sample;
        std::uint64_t overflowed_before = 0;  // samples lost just before it
    };
    struct Buffer {
        std::uint32_t mask = 0;
        std::size_t samples = 0;   // per buffer
        std::size_t capacity = 0;  // of the FIFO
        std::deque<Held> fifo{};
        std::uint64_t overflowed_last = 0;  // samples lost after the newest in the FIFO
        std::size_t wanted = 0;             // samples still to be sent for this READBUF
        bool mask_due = false;
        bool short_end = false;  // the requested bytes are not a whole number of samples
        int error = 0;           // answer to the next READBUF
    };

    void receive();
    void receive_value(IiodCommand command);
    void execute(const IiodCommand& command);
    void open(const IiodCommand& command);
    void read_buffer(const IiodCommand& command);
    void await_samples();
    void send_piece(std::size_t samples);
    void drop_buffer();
    void end_buffer(int error);
    void reply(std::int64_t number) { put(std::to_string(number) + "\n"); }
    void put(const std::string& text);
    void send();

    boost::asio::ip::tcp::socket socket_;
    boost::asio::steady_timer deadline_;
    IiodShared& shared_;
    std::string in_;
    std::vector<char> out_, leaving_;
    std::uint64_t out_samples_ = 0, leaving_samples_ = 0;
    bool sending_ = false;
    std::optional<Buffer> buffer_;
};

}  // namespace shaker::mock
