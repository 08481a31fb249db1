#include "tests/support/remote/socket_client.hpp"

#include <charconv>

namespace shaker::test {

SocketClient::SocketClient(int port, const std::string& target, const std::string& header) : tcp{port} {
    tcp.send_bytes("GET " + target +
                   " HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
                   "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
                   header + "\r\n");
    const std::string got = tcp.until("\r\n\r\n");
    if (got.size() > 12) std::from_chars(got.data() + 9, got.data() + 12, status);
}

// The mask is zero, so the data are unchanged.
void SocketClient::send(Op op, const std::string& data, bool last, bool masked) {
    std::string frame{static_cast<char>((last ? 0x80 : 0) | op)};
    const int mask = masked ? 0x80 : 0;
    if (data.size() < 126) {
        frame += static_cast<char>(mask | static_cast<int>(data.size()));
    } else {
        frame += static_cast<char>(mask | 127);
        for (int shift = 56; shift >= 0; shift -= 8) frame += static_cast<char>(data.size() >> shift);
    }
    if (masked) frame += std::string(4, '\0');
    tcp.send_bytes(frame + data);
}

SocketClient::Message SocketClient::next() {
    const std::string head = tcp.bytes(2);
    if (head.size() < 2) return {};
    std::size_t size = static_cast<unsigned char>(head[1]) & 0x7fU;
    const std::string longer = size < 126 ? "" : tcp.bytes(size == 126 ? 2 : 8);
    if (!longer.empty()) size = 0;
    for (const char c : longer) size = size << 8U | static_cast<unsigned char>(c);
    return {head[0] & 0x0f, tcp.bytes(size)};
}

}  // namespace shaker::test
