#include "daemon/remote/web/download.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>

#include "drivers/descriptor.hpp"
#include "drivers/errors.hpp"
#include "drivers/realtime.hpp"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/serializer.hpp>
#include <boost/beast/http/write.hpp>

namespace shaker::web {

namespace {

namespace asio = boost::asio;
namespace http = boost::beast::http;
using asio::use_awaitable;

constexpr std::size_t part_bytes = std::size_t{1} << 18U;
constexpr std::chrono::seconds part_patience{30};  // for the client to take a part

// A slow disk must not keep the doors from an abort.
asio::thread_pool& disk() {
    static asio::thread_pool thread{1};
    return thread;
}

/// An open recording, and its place among the downloads.
class Opened {
public:
    explicit Opened(Site& site) : site_{site} { ++site_.downloads; }
    Opened(const Opened&) = delete;
    Opened& operator=(const Opened&) = delete;
    ~Opened() { --site_.downloads; }
    Descriptor file;
    std::uint64_t bytes = 0;

private:
    Site& site_;
};

asio::awaitable<void> open_file(Opened& opened, const catalogue::Catalogue& recordings,
                                const catalogue::WantedFile& wanted) {
    use_ordinary_priority();  // the thread has that of the doors, which started it
    struct stat now {};
    try {
        opened.file = recordings.open(wanted);
        if (::fstat(opened.file, &now) == 0) opened.bytes = static_cast<std::uint64_t>(now.st_size);
    } catch (const InputError&) {
    }
    co_return;
}

asio::awaitable<std::size_t> read_part(int file, std::string& part) {
    const ssize_t n = ::read(file, part.data(), part.size());
    co_return n > 0 ? static_cast<std::size_t>(n) : 0;
}

bool may_send(const Site& site) {
    try {
        site.recordings->require_rest();
        return true;
    } catch (const InputError&) {
        return false;
    }
}

}  // namespace

asio::awaitable<void> send_file(boost::beast::tcp_stream& stream, const Request& request,
                                const catalogue::WantedFile& wanted, Site& site,
                                const std::function<void()>& alive) {
    Opened opened{site};
    co_await asio::co_spawn(disk(), open_file(opened, *site.recordings, wanted), use_awaitable);
    http::response<http::empty_body> head{opened.file >= 0 ? http::status::ok : http::status::not_found,
                                          request.version()};
    if (wanted.report) {
        head.set(http::field::content_type, "text/html; charset=utf-8");
        head.set("Content-Security-Policy",
                 "sandbox; default-src 'none'; img-src data:; style-src 'unsafe-inline'");
    } else {
        head.set(http::field::content_type, "application/x-hdf5");
        head.set(http::field::content_disposition, "attachment; filename=\"" + wanted.name + "\"");
    }
    head.set(http::field::cache_control, "no-store");
    head.set("X-Content-Type-Options", "nosniff");
    head.keep_alive(false);
    head.content_length(opened.bytes);
    http::response_serializer<http::empty_body> headings{head};
    stream.expires_after(part_patience);
    co_await http::async_write_header(stream, headings, use_awaitable);
    std::string part(part_bytes, '\0');
    for (std::uint64_t sent = 0; sent < opened.bytes && may_send(site);) {
        std::size_t n = co_await asio::co_spawn(disk(), read_part(opened.file, part), use_awaitable);
        n = static_cast<std::size_t>(std::min<std::uint64_t>(n, opened.bytes - sent));
        if (n == 0) break;
        stream.expires_after(part_patience);
        co_await asio::async_write(stream, asio::buffer(part.data(), n), use_awaitable);
        sent += n;
        alive();
    }
}

}  // namespace shaker::web
