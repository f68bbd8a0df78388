#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace gluevo::apps {

/// Where the view is to be seen.
struct ViewAddress {
  std::string host = "127.0.0.1";
  uint16_t port = 8080;  ///< 0: any that is free.
  std::string token;     ///< Who has it not sees nothing; empty: none.

  bool is_loopback() const;
  /// As an address on the web has it; where it stands for all of this machine's, its name.
  std::string NameForOthers() const;
};

/// PORT, ADDRESS or ADDRESS:PORT ("[::1]:8080" for IPv6). Throws OptionError for anything else.
ViewAddress ParseViewAddress(const std::string& text);

/// What --view and --view-token (nothing, and empty: not given) ask for; other machines need a
/// token, which is made where none is given. Nothing for no view. Throws OptionError for a token
/// without a view, one that cannot stand in an address, and as ParseViewAddress does.
std::optional<ViewAddress> ViewAddressOf(const std::optional<std::string>& view,
                                         const std::string& token);

/// Sixteen hexadecimal digits that nobody can guess.
std::string MakeViewToken();

/// Whether a request is one of this page's own. `host` and `origin`: its headers, empty where there
/// is none; `target`: "/stream?token=...". Other pages that the same browser shows may not ask: a
/// name that is led to this machine is not its own, nor is their origin.
bool IsOwnRequest(const ViewAddress& address, std::string_view host, std::string_view origin,
                  std::string_view target);

}  // namespace gluevo::apps
