#include "view_address.h"

#include <charconv>
#include <random>

#include "gluevo/nn/error.h"
#include "gluevo/nn/option_error.h"

namespace gluevo::apps {
namespace {

// Whether the text is a port; 0 is one.
bool ParsePort(std::string_view text, uint16_t& port) {
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), port);
  return code == std::errc() && end == text.data() + text.size();
}

std::string_view WithoutPort(std::string_view host) {
  const std::size_t colon = host.rfind(':');
  const std::size_t bracket = host.rfind(']');
  return colon == std::string_view::npos || (bracket != std::string_view::npos && colon < bracket)
             ? host
             : host.substr(0, colon);
}

std::string_view TokenOf(std::string_view target) {
  constexpr std::string_view kKey = "?token=";
  const std::size_t key = target.find(kKey);
  return key == std::string_view::npos ? std::string_view() : target.substr(key + kKey.size());
}

// In a time that does not tell how much of it is right.
bool IsSame(std::string_view a, std::string_view b) {
  unsigned difference = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < a.size() && i < b.size(); ++i) {
    difference |= static_cast<unsigned>(a[i] ^ b[i]);
  }
  return difference == 0;
}

}  // namespace

bool ViewAddress::is_loopback() const {
  return host == "localhost" || host == "::1" || host.starts_with("127.");
}

ViewAddress ParseViewAddress(const std::string& text) {
  ViewAddress address;
  if (ParsePort(text, address.port)) {
    return address;
  }
  const std::string_view host = WithoutPort(text);
  const bool has_port = host.size() < text.size();
  if (host.empty() ||
      (has_port && !ParsePort(std::string_view(text).substr(host.size() + 1), address.port))) {
    throw OptionError("--view is " + Quoted(text) + "; expected PORT, ADDRESS or ADDRESS:PORT");
  }
  address.host = host.front() == '[' && host.back() == ']' ? host.substr(1, host.size() - 2) : host;
  return address;
}

std::string MakeViewToken() {
  std::random_device device;
  std::string token;
  for (int i = 0; i < 16; ++i) {
    token += "0123456789abcdef"[device() % 16];
  }
  return token;
}

bool IsOwnRequest(const ViewAddress& address, std::string_view host, std::string_view origin,
                  std::string_view target) {
  if (!origin.empty() && origin != "http://" + std::string(host)) {
    return false;
  }
  if (!address.token.empty()) {
    return IsSame(TokenOf(target), address.token);
  }
  const std::string_view name = WithoutPort(host);
  return name == "localhost" || name == "[::1]" || name.starts_with("127.") || name == address.host;
}

}  // namespace gluevo::apps
