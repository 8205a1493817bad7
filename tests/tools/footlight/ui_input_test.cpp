// Keys of the window, as keyboards of several countries send them, and its mouse between slow pictures.
#include <array>
#include <set>
#include <utility>
#include <vector>

#include <GLFW/glfw3.h>

#include <doctest/doctest.h>

#include "tools/footlight/preview/key_presses.h"
#include "tools/footlight/preview/mouse_queue.h"
#include "tools/footlight/preview/output_feed.h"
#include "tools/footlight/preview/ui/keys.h"
#include "tools/footlight/preview/ui/panels.h"

namespace footlight::tools {
namespace {

// A key of a keyboard: where it is on an American one, its name and the character that it types in its own layout; 0:
// none.
struct Press {
  int key;
  const char* name;
  unsigned int types = 0;
  int mods = 0;
};

// All that one press does.
std::vector<UiAction> actions(const Press& press, int action = GLFW_PRESS) {
  KeyPresses keys;
  keys.take_key(press.key, press.name, action, press.mods);
  if (press.types != 0) keys.take_character(press.types);
  std::vector<UiAction> done;
  for (const KeyPress& one : keys.presses()) {
    if (const auto call = call_of(one)) done.push_back(call->action);
  }
  return done;
}
using Actions = std::vector<UiAction>;

TEST_CASE("no key has two meanings, and every key that does something is in the list") {
  std::set<std::pair<int, int>> seen;
  for (const KeyRow& row : key_rows()) {
    CHECK(seen.emplace(row.key, row.mods).second);
    CHECK((row.keys == nullptr) == (row.does == nullptr));
    const auto call = call_of({row.key, row.mods, false});
    REQUIRE(call);
    CHECK(call->action == row.call.action);
    CHECK(call_of({row.key, row.mods, true}).has_value() == row.repeats);
    if (row.menu != UiMenu::kNone) CHECK(row.keys != nullptr);
  }
  for (std::size_t i = 0; i < panels().size(); ++i) {
    CHECK(seen.emplace(panels()[i].key, 0).second);
    const auto call = call_of({panels()[i].key, 0, false});
    CHECK(!call_of({panels()[i].key, 0, true}));
    REQUIRE(call);
    CHECK(call->action == UiAction::kPanel);
    CHECK(call->argument == static_cast<int>(i));
  }
  CHECK(call_of({kTyped + '3', 0, false})->argument == 2);
  CHECK(call_of({GLFW_KEY_Z, GLFW_MOD_CONTROL | GLFW_MOD_SHIFT, false})->action == UiAction::kRedo);
  CHECK(call_of({GLFW_KEY_Z, GLFW_MOD_CONTROL | GLFW_MOD_NUM_LOCK | GLFW_MOD_CAPS_LOCK, false})->action ==
        UiAction::kUndo);
  CHECK(!call_of({GLFW_KEY_Z, 0, false}));
  CHECK(!call_of({GLFW_KEY_UNKNOWN, 0, false}));
}

TEST_CASE("letters are those of the keyboard's layout") {
  // German.
  CHECK(actions({GLFW_KEY_Y, "z", 0, GLFW_MOD_CONTROL}) == Actions{UiAction::kUndo});
  CHECK(actions({GLFW_KEY_Z, "y", 0, GLFW_MOD_CONTROL}) == Actions{UiAction::kRedo});
  // Dvorak has W where the comma is, L where P is, and a quotation mark where Q is.
  CHECK(actions({GLFW_KEY_COMMA, "w", 'w'}) == Actions{UiAction::kWorkLight});
  CHECK(actions({GLFW_KEY_P, "l", 'l'}) == Actions{UiAction::kHighlight});
  CHECK(actions({GLFW_KEY_SLASH, "z", 0, GLFW_MOD_CONTROL}) == Actions{UiAction::kUndo});
  CHECK(actions({GLFW_KEY_Q, "'", '\''}).empty());
  CHECK(actions({GLFW_KEY_W, ",", ','}).empty());
  CHECK(actions({GLFW_KEY_E, ".", '.'}).empty());
  // Greek has no Latin letters: they are where they are on an American keyboard.
  CHECK(actions({GLFW_KEY_L, "\u03bb", 0x3BB}) == Actions{UiAction::kHighlight});
  CHECK(actions({GLFW_KEY_Z, "\u03b6", 0, GLFW_MOD_CONTROL}) == Actions{UiAction::kUndo});
  // A system that has no names.
  CHECK(actions({GLFW_KEY_L, nullptr}) == Actions{UiAction::kHighlight});
  CHECK(actions({GLFW_KEY_F11, nullptr}) == Actions{UiAction::kFullScreen});
}

TEST_CASE("plus and minus are what is typed, and count once") {
  CHECK(actions({GLFW_KEY_EQUAL, "=", '+', GLFW_MOD_SHIFT}) == Actions{UiAction::kBrighter});  // American
  CHECK(actions({GLFW_KEY_EQUAL, "=", '='}) == Actions{UiAction::kBrighter});
  CHECK(actions({GLFW_KEY_MINUS, "-", '-'}) == Actions{UiAction::kDarker});
  CHECK(actions({GLFW_KEY_KP_ADD, "+", '+'}) == Actions{UiAction::kBrighter});
  CHECK(actions({GLFW_KEY_KP_SUBTRACT, "-", '-'}) == Actions{UiAction::kDarker});
  CHECK(actions({GLFW_KEY_RIGHT_BRACKET, "+", '+'}) == Actions{UiAction::kBrighter});  // German
  CHECK(actions({GLFW_KEY_SLASH, "-", '-'}) == Actions{UiAction::kDarker});
  CHECK(actions({GLFW_KEY_MINUS, "\u00df", 0xDF}).empty());
  CHECK(actions({GLFW_KEY_EQUAL, nullptr}).empty());                                       // a dead accent
  CHECK(actions({GLFW_KEY_APOSTROPHE, "-", '-'}) == Actions{UiAction::kDarker});           // Dvorak
  CHECK(actions({GLFW_KEY_1, "1", '+', GLFW_MOD_SHIFT}) == Actions{UiAction::kBrighter});  // Swiss
}

TEST_CASE("cameras are the digits that are typed") {
  CHECK(actions({GLFW_KEY_6, "6", '6'}) == Actions{UiAction::kCamera});
  CHECK(actions({GLFW_KEY_KP_6, "6", '6'}) == Actions{UiAction::kCamera});
  CHECK(actions({GLFW_KEY_6, "-", '6', GLFW_MOD_SHIFT}) == Actions{UiAction::kCamera});  // French
  CHECK(actions({GLFW_KEY_6, "-", '-'}) == Actions{UiAction::kDarker});
  CHECK(actions({GLFW_KEY_0, "0", '0'}).empty());
}

TEST_CASE("a key with Alt or Super does not act as the key alone") {
  for (const int mods : {GLFW_MOD_ALT, GLFW_MOD_SUPER, GLFW_MOD_ALT | GLFW_MOD_SHIFT}) {
    INFO(mods);
    CHECK(actions({GLFW_KEY_L, "l", 'l', mods}).empty());
    CHECK(actions({GLFW_KEY_EQUAL, "=", '+', mods}).empty());
    CHECK(actions({GLFW_KEY_1, "1", '1', mods}).empty());
    CHECK(actions({GLFW_KEY_F2, nullptr, 0, mods}).empty());
    CHECK(actions({GLFW_KEY_Z, "z", 0, mods | GLFW_MOD_CONTROL}).empty());
    CHECK(actions({GLFW_KEY_ESCAPE, nullptr, 0, mods}).empty());
  }
}

TEST_CASE("a key that is held does again only what may be repeated") {
  const Press question{GLFW_KEY_SLASH, "/", '?', GLFW_MOD_SHIFT};
  CHECK(actions(question) == Actions{UiAction::kPanel});
  CHECK(actions(question, GLFW_REPEAT).empty());
  CHECK(actions({GLFW_KEY_EQUAL, "=", '+', GLFW_MOD_SHIFT}, GLFW_REPEAT) == Actions{UiAction::kBrighter});
  CHECK(actions({GLFW_KEY_1, "1", '1'}, GLFW_REPEAT).empty());
  CHECK(actions({GLFW_KEY_L, "l", 'l'}, GLFW_REPEAT).empty());
  CHECK(actions({GLFW_KEY_L, "l"}, GLFW_RELEASE).empty());
}

TEST_CASE("blackout has a key of its own in every keyboard, one more that acts while text is typed, and no key arms") {
  CHECK(actions({GLFW_KEY_B, "b", 'b'}) == Actions{UiAction::kBlackout});
  CHECK(actions({GLFW_KEY_N, "b", 'b'}) == Actions{UiAction::kBlackout});  // Dvorak
  CHECK(actions({GLFW_KEY_B, "b", 'b'}, GLFW_REPEAT).empty());
  CHECK(actions({GLFW_KEY_F9, nullptr}) == Actions{UiAction::kBlackout});
  CHECK(actions({GLFW_KEY_B, "b", 'B', GLFW_MOD_SHIFT}) == Actions{UiAction::kEndBlackout});
  CHECK(actions({GLFW_KEY_D, "d", 0, GLFW_MOD_CONTROL}) == Actions{UiAction::kDisarm});
  CHECK(acts_always({GLFW_KEY_F9, 0, false}));
  CHECK(!acts_always({GLFW_KEY_F9, GLFW_MOD_ALT, false}));
  CHECK(!acts_always({GLFW_KEY_B, 0, false}));
  CHECK(!acts_always({GLFW_KEY_F8, 0, false}));
}

TEST_CASE("keys of outputs act while a handle is dragged, Escape cancels the drag, and other keys wait") {
  const KeyPress black{GLFW_KEY_B, 0, false};
  const KeyPress end{GLFW_KEY_B, GLFW_MOD_SHIFT, false};
  const KeyPress disarm{GLFW_KEY_D, GLFW_MOD_CONTROL, false};
  const KeyPress always{GLFW_KEY_F9, 0, false};
  const KeyPress escape{GLFW_KEY_ESCAPE, 0, false};
  const KeyPress remove{GLFW_KEY_DELETE, 0, false};
  KeyHolders holders;
  for (const KeyPress& key : {black, end, disarm, always, escape, remove}) {
    CHECK(turn_of(key, holders) == KeyTurn::kActs);
  }
  for (const bool question : {false, true}) {
    holders = {false, question, true};
    for (const KeyPress& key : {black, end, disarm, always}) CHECK(turn_of(key, holders) == KeyTurn::kActs);
    CHECK(turn_of(escape, holders) == KeyTurn::kCancelsDrag);
    CHECK(turn_of(remove, holders) == KeyTurn::kNothing);
  }
  holders = {false, true, false};
  CHECK(turn_of(escape, holders) == KeyTurn::kActs);
  CHECK(turn_of(disarm, holders) == KeyTurn::kActs);
  CHECK(turn_of(remove, holders) == KeyTurn::kNothing);
  holders = {true, false, false};
  CHECK(turn_of(always, holders) == KeyTurn::kActs);
  for (const KeyPress& key : {black, end, disarm, escape}) CHECK(turn_of(key, holders) == KeyTurn::kNothing);
  CHECK(turn_of({GLFW_KEY_F7, GLFW_MOD_ALT, false}, {}) == KeyTurn::kNothing);

  const std::array<KeyPress, 3> keys{disarm, escape, escape};
  CHECK(canceling_key(keys, {false, false, true}) == &keys[1]);
  CHECK(canceling_key(keys, {}) == nullptr);
  CHECK(canceling_key(keys, {true, false, true}) == nullptr);
}

TEST_CASE("keys of views wait while the mouse is held on the stage or the camera flies, and others do not") {
  const KeyPress next{GLFW_KEY_TAB, 0, false};
  const KeyPress split{GLFW_KEY_V, GLFW_MOD_SHIFT, false};
  KeyHolders pressed;
  pressed.press = true;
  KeyHolders flies;
  flies.fly = true;
  for (const KeyPress& key : {next, split}) {
    CHECK(turn_of(key, {}) == KeyTurn::kActs);
    CHECK(turn_of(key, pressed) == KeyTurn::kNothing);
    CHECK(turn_of(key, flies) == KeyTurn::kNothing);
  }
  CHECK(turn_of({GLFW_KEY_F2, 0, false}, pressed) == KeyTurn::kActs);
}

TEST_CASE("while the camera flies letters do nothing, but for its end, storing the view, outputs and Ctrl") {
  KeyHolders holders;
  holders.fly = true;
  for (const int letter : {GLFW_KEY_W, GLFW_KEY_E, GLFW_KEY_Q, GLFW_KEY_R, GLFW_KEY_X}) {
    CHECK(turn_of({letter, 0, false}, {}) == KeyTurn::kActs);
    CHECK(turn_of({letter, 0, false}, holders) == KeyTurn::kNothing);
  }
  CHECK(turn_of({GLFW_KEY_F, GLFW_MOD_SHIFT, false}, holders) == KeyTurn::kNothing);
  for (const KeyPress& key : {KeyPress{GLFW_KEY_V, 0, false}, KeyPress{GLFW_KEY_C, 0, false},
                              KeyPress{GLFW_KEY_ESCAPE, 0, false}, KeyPress{GLFW_KEY_B, 0, false},
                              KeyPress{GLFW_KEY_Z, GLFW_MOD_CONTROL, false}, KeyPress{GLFW_KEY_SPACE, 0, false},
                              KeyPress{GLFW_KEY_F2, 0, false}}) {
    CHECK(turn_of(key, holders) == KeyTurn::kActs);
  }
}

TEST_CASE("a key that is pressed and released between two pictures is down in one of them") {
  KeyTaps taps;
  std::array<bool, KeyTaps::kKeys> down{};
  const auto key = [&](int action) {
    taps.take_key(GLFW_KEY_ENTER, action, 0);
    down[GLFW_KEY_ENTER] = action != GLFW_RELEASE;  // as Dear ImGui's own callback has it
  };
  const auto seen = [&] {
    (void)taps.hold(down);
    return down[GLFW_KEY_ENTER];
  };
  CHECK(!seen());
  key(GLFW_PRESS);
  key(GLFW_RELEASE);
  CHECK(seen());
  CHECK(!seen());
  CHECK(!seen());
  key(GLFW_PRESS);  // held over two pictures
  CHECK(seen());
  CHECK(seen());
  key(GLFW_RELEASE);
  CHECK(!seen());
  key(GLFW_PRESS);
  key(GLFW_RELEASE);
  CHECK(seen());
  key(GLFW_PRESS);
  key(GLFW_RELEASE);
  CHECK(!seen());  // so that the second press is one of its own
  CHECK(seen());
  CHECK(!seen());
  taps.take_key(GLFW_KEY_UNKNOWN, GLFW_PRESS, 0);
  taps.take_key(100'000, GLFW_PRESS, 0);
  CHECK(!taps.hold(down));
}

TEST_CASE("commands of a field that come between two pictures are seen one after the other, with their Ctrl") {
  KeyTaps taps;
  std::array<bool, KeyTaps::kKeys> down{};
  const auto key = [&](int code, int action, int mods = 0) {
    taps.take_key(code, action, mods);
    down[static_cast<std::size_t>(code)] = action != GLFW_RELEASE;
  };
  const auto tap = [&](int code, int mods = 0) {
    key(code, GLFW_PRESS, mods);
    key(code, GLFW_RELEASE, mods);
  };
  key(GLFW_KEY_LEFT_CONTROL, GLFW_PRESS);
  tap(GLFW_KEY_A, GLFW_MOD_CONTROL);
  key(GLFW_KEY_LEFT_CONTROL, GLFW_RELEASE, GLFW_MOD_CONTROL);
  key(GLFW_KEY_DELETE, GLFW_PRESS);  // and held
  tap(GLFW_KEY_X);                   // its character is in the field already
  tap(GLFW_KEY_HOME, GLFW_MOD_SHIFT);
  CHECK(taps.hold(down) == GLFW_MOD_CONTROL);
  CHECK(down[GLFW_KEY_A]);
  CHECK(!down[GLFW_KEY_DELETE]);
  CHECK(!down[GLFW_KEY_HOME]);
  CHECK(taps.hold(down) == 0);
  CHECK(!down[GLFW_KEY_A]);
  CHECK(down[GLFW_KEY_DELETE]);
  CHECK(!down[GLFW_KEY_HOME]);
  CHECK(taps.hold(down) == GLFW_MOD_SHIFT);
  CHECK(down[GLFW_KEY_DELETE]);
  CHECK(down[GLFW_KEY_HOME]);
  CHECK(!taps.hold(down));
  CHECK(down[GLFW_KEY_DELETE]);
  CHECK(!down[GLFW_KEY_HOME]);
}

TEST_CASE("the key of the dead man's switch is held from its press to its release") {
  HeldKey key(kHoldKey);
  CHECK(!key.held());
  key.take_key(GLFW_KEY_END, GLFW_PRESS);  // it may have been down before the window was there
  key.take_key(GLFW_KEY_END, GLFW_REPEAT);
  CHECK(!key.held());
  key.take_key(GLFW_KEY_END, GLFW_RELEASE);
  key.take_key(GLFW_KEY_END, GLFW_PRESS);
  CHECK(key.held());
  key.take_key(GLFW_KEY_HOME, GLFW_RELEASE);
  key.take_key(GLFW_KEY_END, GLFW_REPEAT);
  CHECK(key.held());
  key.take_key(GLFW_KEY_END, GLFW_RELEASE);
  CHECK(!key.held());
  key.take_key(GLFW_KEY_END, GLFW_REPEAT);
  CHECK(!key.held());
  // It means nothing else, with whatever other keys are held.
  for (const int mods : {0, GLFW_MOD_SHIFT, GLFW_MOD_CONTROL, GLFW_MOD_CONTROL | GLFW_MOD_SHIFT}) {
    CHECK(!call_of({kHoldKey, mods, false}));
  }
}

TEST_CASE("a key that is held while the window loses and regains the keyboard or is iconified counts again only anew") {
  for (const bool icon : {false, true}) {
    HeldKey key(kHoldKey);
    OutputFeed feed(std::vector<Universe>{1});
    TimeNs now_ns = 0;
    const auto live = [&] {  // a turn of the window
      now_ns += 17 * kNsPerMs;
      feed.hold(now_ns, key.held());
      return feed.darkness() == Darkness::kNone;
    };
    feed.need_hold(true);
    CHECK(!live());
    key.take_key(GLFW_KEY_END, GLFW_PRESS);
    key.take_key(GLFW_KEY_END, GLFW_RELEASE);
    CHECK(!live());
    key.take_key(GLFW_KEY_END, GLFW_PRESS);
    CHECK(live());
    if (icon) key.let_go();
    key.take_focus(false);
    key.take_key(GLFW_KEY_END, GLFW_RELEASE);  // made up by GLFW
    CHECK(!live());
    key.take_focus(true);
    if (icon) key.let_go();
    CHECK(!live());
    key.take_key(GLFW_KEY_END, GLFW_PRESS);  // how X repeats the key that is still held
    CHECK(!live());
    for (int i = 0; i < 100; ++i) {
      key.take_key(GLFW_KEY_END, GLFW_REPEAT);
      CHECK(!live());
    }
    key.take_key(GLFW_KEY_END, GLFW_RELEASE);
    CHECK(!live());
    key.take_key(GLFW_KEY_END, GLFW_PRESS);
    CHECK(live());
  }
}

TEST_CASE("a hang in which the window loses the keyboard and regains it with the key held lights nothing up") {
  HeldKey key(kHoldKey);
  OutputFeed feed(std::vector<Universe>{1});
  feed.need_hold(true);
  feed.hold(0, key.held());
  key.take_key(GLFW_KEY_END, GLFW_RELEASE);
  key.take_key(GLFW_KEY_END, GLFW_PRESS);
  feed.hold(kNsPerMs, key.held());
  CHECK(feed.darkness() == Darkness::kNone);
  // All of it comes in the turn after the hang.
  key.take_focus(false);
  key.take_key(GLFW_KEY_END, GLFW_RELEASE);
  key.take_focus(true);
  key.take_key(GLFW_KEY_END, GLFW_PRESS);
  for (int turn = 0; turn < 3; ++turn) {
    feed.hold(kNsPerS + turn * kNsPerMs, key.held());
    CHECK(feed.darkness() == Darkness::kNotHeld);
    key.take_key(GLFW_KEY_END, GLFW_REPEAT);
  }
}

TEST_CASE("a drag between two pictures begins where the button went down and ends where it went up") {
  MouseQueue mouse;
  CHECK(!mouse.next());
  mouse.take_move(5, 5);
  mouse.take_move(10, 20);
  mouse.take_button(0, true, GLFW_MOD_CONTROL);
  mouse.take_move(50, 60);
  mouse.take_move(110, 120);
  mouse.take_button(0, false, 0);
  mouse.take_move(300, 300);
  auto moment = mouse.next();
  REQUIRE(moment);
  CHECK(moment->x == 10);
  CHECK(moment->y == 20);
  CHECK(moment->down == std::array<bool, 3>{true, false, false});
  CHECK(moment->mods == GLFW_MOD_CONTROL);
  moment = mouse.next();  // where it was moved to, while the button is down: a drag moves before it ends
  REQUIRE(moment);
  CHECK(moment->x == 110);
  CHECK(moment->y == 120);
  CHECK(moment->down == std::array<bool, 3>{true, false, false});
  moment = mouse.next();
  REQUIRE(moment);
  CHECK(moment->x == 110);
  CHECK(moment->y == 120);
  CHECK(moment->down == std::array<bool, 3>{});
  CHECK(moment->mods == GLFW_MOD_CONTROL);  // a list takes a click at its release, when Ctrl is up already
  moment = mouse.next();
  REQUIRE(moment);
  CHECK(moment->x == 300);
  CHECK(!mouse.next());
}

TEST_CASE("a mouse that only moves is where it is, and a button that is held stays down") {
  MouseQueue mouse;
  mouse.take_button(1, true, 0);
  CHECK(mouse.next()->down[1]);
  for (int i = 0; i < 10'000; ++i) mouse.take_move(static_cast<float>(i), 0);
  const auto moment = mouse.next();
  REQUIRE(moment);
  CHECK(moment->x == 9999);
  CHECK(moment->down[1]);
  CHECK(!mouse.next());
  // A fourth button is nothing to the window.
  mouse.take_button(3, true, 0);
  CHECK(!mouse.next());
}

TEST_CASE("a mouse that is clicked during a long picture does not fill the memory") {
  MouseQueue mouse;
  for (int i = 0; i < 1000; ++i) {
    mouse.take_button(0, i % 2 == 0, 0);
    mouse.take_move(static_cast<float>(i), 0);
  }
  mouse.take_button(0, true, 0);
  std::size_t pictures = 0;
  bool down = false;
  while (const auto moment = mouse.next()) {
    ++pictures;
    down = moment->down[0];
  }
  CHECK(pictures <= MouseQueue::kEventsMax);
  CHECK(down);
}

}  // namespace
}  // namespace footlight::tools
