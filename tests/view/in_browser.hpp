// A page in headless Chromium: what a script asks it.
#pragma once

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "perp/view/page.hpp"
#include "tests/cli/program.hpp"
#include "view/browser.hpp"

namespace perp {

/// What `script`, put at the end of the page, leaves in `out`; fails where the page complained of anything.
inline nlohmann::json asked(const Scratch& scratch, const std::string& browser, const std::string& script,
                            const std::string& fragment = "bare") {
  std::string page = contents(scratch / "page.html");
  page.insert(
      page.find("<head>") + 6,
      "<script>const complaints = []; window.addEventListener('error', e => complaints.push(e.message), "
      "true);"
      "for (const k of ['error', 'warn']) console[k] = (...x) => complaints.push(x.join(' '));</script>");
  page.insert(page.rfind("</body>"),
              "<script>const out = {}; try {" + script +
                  "} catch (error) { out.error = String(error); }\nout.complaints = complaints;"
                  "document.body.innerHTML = '<pre id=\"out\"></pre>';"
                  "document.getElementById('out').textContent = "
                  "btoa(unescape(encodeURIComponent(JSON.stringify(out))));</script>");
  std::ofstream(scratch / "asked.html", std::ios::binary) << page;
  const std::string document = document_of(browser, scratch / "asked.html", fragment, 800, 600);
  const std::string begin = "<pre id=\"out\">";
  const std::size_t from = document.find(begin) + begin.size();
  const std::string letters = document.substr(from, document.find("</pre>", from) - from);
  std::string text;  // of base64
  int bits = 0;
  unsigned value = 0;
  for (const char c : letters) {
    const std::string all = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const std::size_t digit = all.find(c);
    if (digit == std::string::npos) break;
    value = value << 6 | static_cast<unsigned>(digit);
    bits += 6;
    if (bits >= 8) bits -= 8, text += static_cast<char>(value >> bits & 255);
  }
  const nlohmann::json out = nlohmann::json::parse(text);
  INFO(out.dump());
  REQUIRE_FALSE(out.contains("error"));
  REQUIRE(out["complaints"].empty());
  return out;
}

inline std::string need_browser() {
  const std::string browser = find_browser();
  if (browser.empty() || !std::filesystem::exists("/usr/share/javascript/three/build/three.min.js"))
    WARN("skipped: chromium or libjs-three is not installed");
  return browser;
}

}  // namespace perp
