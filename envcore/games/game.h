#ifndef ENVCORE_GAMES_GAME_H_
#define ENVCORE_GAMES_GAME_H_

#include <array>
#include <cstddef>
#include <cstdint>

#include "absl/types/span.h"
#include "envcore/games/game_options.h"
#include "envcore/level/generated_art.h"
#include "envcore/random/random_stream.h"
#include "envcore/scene/art_slot.h"
#include "envcore/scene/scene.h"
#include "envcore/state/state_archive.h"
#include "envcore/world/rules.h"
#include "envcore/world/world.h"

namespace procgen {

// Facts about a game's art that are rules: how many themes a kind has and how wide its pictures are
// decides draws and sizes.
struct GameArtSpec {
  absl::Span<const ArtSlot> slots;                // of the game's own; the shared ones come on top
  absl::Span<const int> block_shaped_kinds = {};  // generated art fills the canvas for these
  absl::Span<const int> kept_theme_kinds = {};    // keep their themes when themes are restricted
  BackgroundGroup background_group = BackgroundGroup::kPlatform;
  float background_tile_ratio = 0;
  bool background_scrolls = false;  // moves to the left with time
};

// What a step brought.
struct StepOutcome {
  float reward = 0;
  bool done = false;            // the game ended the level
  bool level_complete = false;  // and it was completed
};

// A game: its rules over one world, and how that looks. A game's file derives from this, makes
// levels (MakeLevel), plays steps (PlayStep) and answers the rules' questions; all that games share
// is here, in the order that the specification gives. A game knows no episodes: levels follow one
// another through StartLevel. Threads: compatible (one thread at a time).
class Game : public Rules {
 public:
  // `art` must outlive the game.
  Game(const GameArtSpec& art, const GameOptions& options);

  // Begins the level of `level_seed`.
  void StartLevel(int32_t level_seed);
  // Plays one step with `action` in [0, kActionCount).
  void Play(int32_t action);

  // Saves or restores what changes while a level is played; steps are in [0, step_number_max]. What
  // the level's seed determines is not visited: restoring REQUIRES that StartLevel was called with
  // the seed of the level that was saved.
  void VisitState(StateArchive& archive, int32_t step_number_max);

  const StepOutcome& outcome() const { return outcome_; }
  // Steps played in this level.
  int32_t step_number() const { return step_number_; }
  const GameArtSpec& art() const { return art_; }
  const GameOptions& options() const { return options_; }
  const World& world() const { return world_; }
  const RandomStream& random() const { return random_; }

  // Fills `scene` with what is to be seen now. The scene refers to this game and is good until it
  // moves on.
  void FillScene(Scene* scene) const;

 protected:
  // Makes a new level; calls StandardReset first.
  virtual void MakeLevel() = 0;
  // Plays one step; calls StandardStep first.
  virtual void PlayStep() = 0;

  // The standard reset: background draws, no entities but the agent at a drawn place, all cells
  // empty.
  enum class AgentStart { kRandom, kFixed };
  void StandardReset(int width, int height, AgentStart agent_start = AgentStart::kRandom);
  // The standard step: controls, the agent's velocity, motion, contacts, removal.
  void StandardStep();
  // The motion alone: moves every entity, from last to first, without contacts and removal.
  void MoveEntities();

  // The members of a game's own that change while a level is played, or survive it. Where a
  // restored value could break what the game relies on, it is checked here. By default none.
  virtual void VisitOwnState(StateArchive& /*archive*/) {}
  // How many entities a snapshot may have.
  virtual size_t EntityCountMax() const;

  // Changes the controls, which hold the action's direction, to what the game makes of it.
  virtual void MapControls() {}
  // Updates the agent's velocity from the controls (not called in whole-cell motion).
  virtual void UpdateAgentVelocity();

  // Rules, with the standard answers: walls and what lies outside block, nothing reflects, contacts
  // have no effect.
  bool Blocks(const Entity& mover, int kind, Axis axis) override;
  bool Reflects(const Entity& mover, int kind) override;
  void OnAgentContact(Entity& other) override;
  void OnEntityContact(Entity& self, Entity& other) override;
  void OnCellContact(Entity& entity, int kind, int x, int y) override;

  // The camera: by default follows the agent, or shows the whole world.
  virtual Camera MakeCamera() const;
  // The image kind that an entity shows; negative: it is not drawn.
  virtual int ImageKindOf(const Entity& entity) const;
  // Last changes to an entity's sprite.
  virtual void StyleSprite(const Entity& entity, Sprite* sprite) const;
  // Shapes over everything else; by default none.
  virtual void AddOverlays(std::vector<Overlay>* overlays) const;

  // How many themes a kind has, and a draw among them (a draw also when there is one).
  int ThemeCount(int kind) const;
  int DrawTheme(int kind) { return random_.Int(ThemeCount(kind)); }
  // Width / height of the picture of a kind and theme in the art of Procgen 0.10.7.
  float AspectRatio(int kind, int theme) const;

  // The camera's centre and width follow the rule "centred on the agent" with `cells_in_view_`
  // across, or show the world.
  bool center_agent_;
  float cells_in_view_ = 16;
  // Standard velocity update: share of the new velocity, top speed; the jump speed limits the
  // velocity display only.
  float mix_ = 0.5F;
  float top_speed_ = 0.5F;
  float jump_speed_ = 0.5F;
  bool shows_velocity_ = true;
  // How each kind of cell looks; a new level starts with every kind showing its own picture in
  // theme 0.
  std::array<CellLook, kKindCount> cell_looks_;
  // The kind of cell that shows a flat dot; by default none.
  CellDots cell_dots_;

  RandomStream random_;  // the level stream
  World world_;
  StepOutcome outcome_;
  int32_t special_action_ = 0;  // 0: none, 1 ... 6 for the actions 9 ... 14
  int32_t last_move_ = 7;       // the last move that was not "none"; survives levels
  int32_t background_index_ = 0;

 private:
  // Fails where an entity would stop others that only cells stop: the motion of one among many that
  // do would not end in our time.
  void CheckNoneBlocks(StateArchive& archive);
  const ArtSlot* FindSlot(int kind, int theme) const;
  // The theme that is looked up for a stored one: 0 where themes are restricted.
  int ShownTheme(int kind, int theme) const;
  void AddSprites(int layer, std::vector<Sprite>* sprites) const;
  void FillCells(const Camera& camera, CellLayer* cells) const;

  const GameArtSpec& art_;
  const GameOptions options_;
  int32_t step_number_ = 0;
  int32_t move_ = kNoAction;
  float background_offset_ = 0;
  GeneratedArt generated_background_;
};

}  // namespace procgen

#endif  // ENVCORE_GAMES_GAME_H_
