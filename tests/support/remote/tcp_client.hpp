#pragma once
// A client of a local port or Unix socket for lines or bytes.
#include <filesystem>
#include <string>
#include <string_view>

namespace shaker::test {

/// Every wait ends after 5 s with the bytes received so far.
class TcpClient {
public:
    explicit TcpClient(int port);
    /// The same for a Unix socket.
    explicit TcpClient(const std::filesystem::path& socket);
    ~TcpClient();
    TcpClient(const TcpClient&) = delete;
    TcpClient& operator=(const TcpClient&) = delete;

    /// A line; LF is added.
    void send(std::string_view line);
    void send_bytes(std::string_view bytes);
    void send_no_more();
    /// The next line without its LF.
    std::string line();
    std::string ask(std::string_view line_) {
        send(line_);
        return line();
    }
    /// A block of the instrument language (#<n><length><data>) and the LF behind it.
    std::string block();
    /// This number of bytes.
    std::string bytes(std::size_t n);
    /// Reads up to and including `end`.
    std::string until(std::string_view end);
    /// The next bytes, at least one; empty at the end.
    std::string some();
    /// All bytes until the other side closes.
    std::string rest();
    /// True if the other side closes within this time. Discards the bytes received before.
    bool closed(int within_ms = 5000);

private:
    bool more();

    int socket_;
    std::string buffer_;
};

}  // namespace shaker::test
