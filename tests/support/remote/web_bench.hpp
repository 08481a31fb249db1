#pragma once
// A served web side over a simulated bench, and requests to it.
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "daemon/remote/server.hpp"
#include "tests/support/program.hpp"
#include "tests/support/remote/played_bench.hpp"
#include "tests/support/remote/tcp_client.hpp"

namespace shaker::test {

/// An answer; status 0: none came.
struct Got {
    int status = 0;
    std::string head, body;
};

inline remote::ServerSettings settings_with_page() {
    const auto folder = fresh_folder();
    std::ofstream{folder / "index.html"} << "<!doctype html>the page";
    return {.http_port = 0, .scpi_port = 0, .page = folder};
}

struct WebBench : testing::Test {
    PlayedBench bench;
    remote::Server server{bench.bench_port, settings_with_page()};

    Got request(const std::string& first, const std::string& body = {}, const std::string& more = {},
                const std::string& host = "localhost") {
        TcpClient client{server.http_port()};
        client.send_bytes(first + " HTTP/1.1\r\nHost: " + host + "\r\nConnection: close\r\n" + more +
                          "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
        const std::string all = client.rest();
        Got got;
        const std::size_t end = all.find("\r\n\r\n");
        if (end == std::string::npos) return got;
        got.head = all.substr(0, end);
        got.body = all.substr(end + 4);
        got.status = std::stoi(all.substr(9, 3));
        return got;
    }
    Got post(const std::string& action, const std::string& body, const std::string& client = "tab1") {
        return request("POST /api/" + action, body, "X-Shaker-Client: " + client + "\r\n");
    }
};

}  // namespace shaker::test
