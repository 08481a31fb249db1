#pragma once
// A client of the daemon's live socket that may send any frame, right or wrong.
#include <cstdint>
#include <string>

#include "tests/support/tcp_client.hpp"

namespace shaker::test {

class SocketClient {
public:
    enum Op : std::uint8_t { more = 0, text = 1, binary = 2, close = 8, ping = 9, pong = 10 };
    struct Message {
        int op = -1;  // -1: nothing came within 5 s
        std::string data;
    };

    /// Asks for the upgrade; `more`: further lines of the header.
    explicit SocketClient(int port, const std::string& target = "/ws", const std::string& header = {});
    /// Of the upgrade's answer; 101: it was taken. 0: there was none.
    int status = 0;

    void send(Op op, const std::string& data, bool last = true, bool masked = true);
    Message next();
    TcpClient tcp;
};

}  // namespace shaker::test
