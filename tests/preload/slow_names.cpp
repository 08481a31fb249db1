// A name server that does not answer: the name "silent.test" is not found, after a minute.
#include <netdb.h>

#include <chrono>
#include <string_view>
#include <thread>

#include "tests/preload/interposed.hpp"

extern "C" int getaddrinfo(const char* name, const char* service, const addrinfo* hints, addrinfo** found) {
    static auto* const real = shaker::interposed::real<decltype(::getaddrinfo)>("getaddrinfo");
    if (name == nullptr || std::string_view{name} != "silent.test") return real(name, service, hints, found);
    std::this_thread::sleep_for(std::chrono::minutes{1});
    return EAI_AGAIN;
}
