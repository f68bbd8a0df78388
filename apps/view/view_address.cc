#include "view_address.h"

#include <unistd.h>

#include <charconv>
#include <random>

#include "gluevo/nn/error.h"
#include "gluevo/nn/option_error.h"

namespace gluevo::apps {
namespace {

bool IsNumber(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

// Of a number; 0 is a port, too.
uint16_t ParsePort(std::string_view number, const std::string& view) {
  uint16_t port = 0;
  if (std::from_chars(number.data(), number.data() + number.size(), port).ec != std::errc()) {
    throw OptionError("--view is " + Quoted(view) + "; expected a port up to 65535");
  }
  return port;
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

std::string ViewAddress::NameForOthers() const {
  char name[256] = {};
  const bool is_all = host == "0.0.0.0" || host == "::";
  if (is_all && gethostname(name, sizeof(name) - 1) == 0) {
    return name;
  }
  return host.find(':') != std::string::npos ? "[" + host + "]" : host;
}

bool ViewAddress::is_loopback() const {
  return host == "localhost" || host == "::1" || host.starts_with("127.");
}

ViewAddress ParseViewAddress(const std::string& text) {
  ViewAddress address;
  if (IsNumber(text)) {
    address.port = ParsePort(text, text);
    return address;
  }
  const std::string_view host = WithoutPort(text);
  const bool has_port = host.size() < text.size();
  const std::string_view port = std::string_view(text).substr(host.size() + (has_port ? 1 : 0));
  if (host.empty() || (has_port && !IsNumber(port))) {
    throw OptionError("--view is " + Quoted(text) +
                      "; expected PORT, ADDRESS or ADDRESS:PORT, as in 8080 or 0.0.0.0:8080");
  }
  if (has_port) {
    address.port = ParsePort(port, text);
  }
  address.host = host.front() == '[' && host.back() == ']' ? host.substr(1, host.size() - 2) : host;
  return address;
}

std::optional<ViewAddress> ViewAddressOf(const std::optional<std::string>& view,
                                         const std::string& token) {
  if (!view) {
    if (!token.empty()) {
      throw OptionError("--view-token is of a view; expected --view, too");
    }
    return std::nullopt;
  }
  ViewAddress address = ParseViewAddress(*view);
  if (token.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_") !=
      std::string::npos) {
    throw OptionError("--view-token is no part of an address; expected letters, digits, - and _");
  }
  address.token = token.empty() && !address.is_loopback() ? MakeViewToken() : token;
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
