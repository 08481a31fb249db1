#pragma once
// A client of a port on this machine that speaks lines, or bytes.
#include <string>
#include <string_view>

namespace shaker::test {

/// Every wait ends after 5 s with what came so far.
class TcpClient {
public:
    explicit TcpClient(int port);
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
    /// So many bytes.
    std::string bytes(std::size_t n);
    /// Up to and with `end`.
    std::string until(std::string_view end);
    /// What comes next, at least a byte; empty at the end.
    std::string some();
    /// All until the other side closes.
    std::string rest();
    /// The other side has closed, within so long. What it sent before is gone then.
    bool closed(int within_ms = 5000);

private:
    bool more();

    int socket_;
    std::string buffer_;
};

}  // namespace shaker::test
