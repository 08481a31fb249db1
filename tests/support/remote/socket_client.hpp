#pragma once
// A client of the daemon's WebSocket that can send any frame, valid or not.
#include <cstdint>
#include <string>

#include "tests/support/remote/tcp_client.hpp"

namespace shaker::test {

class SocketClient {
public:
    enum Op : std::uint8_t { more = 0, text = 1, binary = 2, close = 8, ping = 9, pong = 10 };
    struct Message {
        int op = -1;  // -1: no frame within 5 s
        std::string data;
    };

    /// Requests the upgrade; `more`: further lines of the header.
    explicit SocketClient(int port, const std::string& target = "/ws", const std::string& header = {});
    /// HTTP status of the answer to the upgrade; 101: accepted, 0: no answer.
    int status = 0;

    void send(Op op, const std::string& data, bool last = true, bool masked = true);
    Message next();
    TcpClient tcp;
};

}  // namespace shaker::test
