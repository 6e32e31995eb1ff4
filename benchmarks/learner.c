/*
 * The learning of learners/kernel/loop.py in C, draw for draw and bit for bit: the yardstick that
 * the compiled loop is measured by. It keeps no record of the run but how the trials ended.
 *
 *     cc -O3 -march=native -o learner learner.c -lm
 *     ./learner --seed 1 --trials 24000          (all settings: see usage)
 *
 * The draws, the row of a table and the frame of the board are those of sim/ and learners/. What
 * is done otherwise because it is faster: one record for each cell; the rows of all skills in one
 * state side by side; a row is rescanned as one vector; the next draw is made a step ahead; a loop
 * of its own for each kind of step, without tests of what is constant.
 */
#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#else
#pragma GCC optimize("fp-contract=off") /* a fused multiply-add would round differently */
#endif

#define _GNU_SOURCE
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#if defined(__AVX512F__) || defined(__BMI2__)
#include <immintrin.h>
#endif

#define ALWAYS_INLINE static inline __attribute__((always_inline))
#define NOINLINE __attribute__((noinline))
#define LIKELY(x) __builtin_expect(!!(x), 1)
#define UNLIKELY(x) __builtin_expect(!!(x), 0)

enum { N_HEADINGS = 8, N_MOVES = 9, MAX_ACTIONS = 12, MAX_SKILLS = 12, MAX_EPISODES = 2048 };
enum { PREY_BIT = 1 << 8, FRAME_BIT = 1 << 9 };
#define NO_OPTION 255u

/* ------------------------------------------------------------------ random numbers, rng.py */

#define GAMMA 0x9E3779B97F4A7C15u

ALWAYS_INLINE uint64_t mix(uint64_t counter)
{
    uint64_t z = (counter ^ (counter >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

/* ------------------------------------------------------------------ settings */

typedef struct {
    int size, n_directions, n_distances, step_limit;
    double ring_exponent, vision_radius, start_nearest, start_farthest;
    float capture_reward, flight_reward;
} WorldSettings;

typedef struct {
    float gain, arc, inward; /* weights of the local reward */
    int64_t at, freeze;
} Skill;

typedef struct {
    uint32_t option;
    int64_t start, duration;
    double probability;
} Episode;

typedef struct {
    WorldSettings world;
    bool moves; /* the options are the primitive moves */
    bool safe_introduction;
    int n_skills, n_episodes;
    Skill skills[MAX_SKILLS];
    Episode episodes[MAX_EPISODES];
    float alpha, skill_alpha, gamma, initial_q;
    double epsilon;
    uint64_t seed;
    int64_t trials;
} Settings;

/* ------------------------------------------------------------------ tables */

/* One line of the cache, as in learners/kernel/rows.py: the values, the largest of them, an upper
   bound of all but the largest, and the set of actions that have the largest. */
typedef struct {
    float q[MAX_ACTIONS];
    float best, second;
    uint32_t greedy, unused;
} Row;

/* A cell of the board or of the frame around it; one of the frame reads like its neighbour. */
typedef struct {
    uint32_t state; /* direction and ring */
    uint32_t bits;  /* visibility by heading, prey, frame */
    float distance, angle;
} Cell;

typedef struct {
    Settings settings;
    Cell *cells;
    uint32_t *clipped;
    int32_t move_step[16];
    size_t n_skill_states;
    Row *selection;       /* (heading, state) */
    Row *skills;          /* (state, skill), 2 ** skill_shift rows for each state */
    uint32_t skill_shift;
    int64_t step, trial, captures, flights, timeouts;
    uint64_t decisions, starts;
    uint32_t cell, heading;
} Learner;

/* What holds from one event of the schedule to the next. */
typedef struct {
    uint32_t present;
    float alpha;
    int n_episodes;
    uint32_t episode_option[MAX_SKILLS]; /* one for each skill at most */
    uint64_t episode_chance[MAX_SKILLS];
} Phase;

static void *table_memory(size_t bytes)
{
    const size_t page = (size_t)1 << 21;
    const size_t rounded = (bytes + page - 1) / page * page;
    void *memory = aligned_alloc(page, rounded);
    if (!memory) {
        fprintf(stderr, "learner: no memory for a table of %zu bytes\n", bytes);
        exit(1);
    }
#ifdef MADV_HUGEPAGE
    madvise(memory, rounded, MADV_HUGEPAGE); /* fewer pages to translate */
#endif
    return memory;
}

/* ------------------------------------------------------------------ rows */

#ifdef __AVX512F__
#define ACTION_LANES ((__mmask16)0x0FFF)

/* Write a value, and find the largest, the next and the greedy set anew. */
static NOINLINE void rescan(Row *row, uint32_t action, float value)
{
    const __m512 none = _mm512_set1_ps(-INFINITY);
    /* Loaded before the value is stored: a wide load right after a narrow store has to wait. */
    const __m512 stored = _mm512_mask_loadu_ps(none, ACTION_LANES, row);
    const __m512 values =
        _mm512_mask_mov_ps(stored, (__mmask16)(1u << action), _mm512_set1_ps(value));
    const float top = _mm512_reduce_max_ps(values);
    const __mmask16 members =
        _mm512_mask_cmp_ps_mask(ACTION_LANES, values, _mm512_set1_ps(top), _CMP_EQ_OQ);
    row->greedy = members;
    row->q[action] = value;
    row->best = top;
    row->second = _mm512_reduce_max_ps(_mm512_mask_mov_ps(values, members, none));
}

ALWAYS_INLINE uint32_t greedy_by_scan(const Row *row, uint32_t allowed)
{
    const __m512 none = _mm512_set1_ps(-INFINITY);
    const __m512 values = _mm512_mask_loadu_ps(none, (__mmask16)allowed, row);
    const float top = _mm512_reduce_max_ps(values);
    return _mm512_mask_cmp_ps_mask((__mmask16)allowed, values, _mm512_set1_ps(top), _CMP_EQ_OQ);
}
#else
static NOINLINE void rescan(Row *row, uint32_t action, float value)
{
    float top = -INFINITY, second = -INFINITY;
    uint32_t members = 0;
    row->q[action] = value;
    for (int a = 0; a < MAX_ACTIONS; a++) top = row->q[a] > top ? row->q[a] : top;
    for (int a = 0; a < MAX_ACTIONS; a++) {
        const bool is_greedy = row->q[a] == top;
        members |= (uint32_t)is_greedy << a;
        second = !is_greedy && row->q[a] > second ? row->q[a] : second;
    }
    row->greedy = members;
    row->best = top;
    row->second = second;
}

ALWAYS_INLINE uint32_t greedy_by_scan(const Row *row, uint32_t allowed)
{
    float top = -INFINITY;
    uint32_t members = 0;
    for (uint32_t left = allowed; left; left &= left - 1) {
        const int action = __builtin_ctz(left);
        if (row->q[action] > top) {
            top = row->q[action];
            members = 0;
        }
        members |= (uint32_t)(row->q[action] == top) << action;
    }
    return members;
}
#endif

ALWAYS_INLINE void backup(Row *row, uint32_t action, float target, float alpha)
{
    const float q_tm1 = row->q[action];
    const float value = q_tm1 + alpha * (target - q_tm1);
    const uint32_t members = row->greedy, this = 1u << action;
    /* The only greedy action first: whether its value rises or falls is a coin's toss that no
       predictor learns, and need not be asked while it stays above the others. */
    if (LIKELY(members == this)) {
        if (LIKELY(value > row->second))
            row->q[action] = row->best = value;
        else
            rescan(row, action, value);
        return;
    }
    const float top = row->best;
    row->q[action] = value;
    if (value < top) {
        row->greedy = members & ~this;
        row->second = value > row->second ? value : row->second;
    } else if (value == top) {
        row->greedy = members | this;
    } else {
        row->second = top;
        row->best = value;
        row->greedy = this;
    }
}

/* A member of the set by a uniform draw of 16 bits. */
ALWAYS_INLINE uint32_t pick(uint32_t members, uint32_t draw16)
{
    if (LIKELY((members & (members - 1)) == 0)) return (uint32_t)__builtin_ctz(members);
    uint32_t skip = (draw16 * (uint32_t)__builtin_popcount(members)) >> 16;
#ifdef __BMI2__
    return (uint32_t)__builtin_ctz(_pdep_u32(1u << skip, members));
#else
    while (skip--) members &= members - 1;
    return (uint32_t)__builtin_ctz(members);
#endif
}

/* ------------------------------------------------------------------ the loop */

static void start_of_trial(Learner *learner)
{
    const WorldSettings *world = &learner->settings.world;
    const uint64_t counter = learner->starts + (uint64_t)learner->trial * 3 * GAMMA;
    const double unit = 0x1p-53;
    const double radius = world->start_nearest + (world->start_farthest - world->start_nearest) *
                                                     ((double)(mix(counter + GAMMA) >> 11) * unit);
    const double angle = 2.0 * M_PI * ((double)(mix(counter + 2 * GAMMA) >> 11) * unit);
    const int middle = world->size / 2;
    int x = (int)floor(middle + radius * cos(angle) + 0.5);
    int y = (int)floor(middle + radius * sin(angle) + 0.5);
    x = x < 0 ? 0 : x > world->size - 1 ? world->size - 1 : x;
    y = y < 0 ? 0 : y > world->size - 1 ? world->size - 1 : y;
    learner->cell = (uint32_t)((y + 1) * (world->size + 2) + x + 1);
    learner->heading = (uint32_t)(mix(counter + 3 * GAMMA) >> 61);
}

ALWAYS_INLINE float wrapped(float angle)
{
    const float pi = (float)M_PI, turn = (float)(2 * M_PI);
    return angle > pi ? angle - turn : angle < -pi ? angle + turn : angle;
}

ALWAYS_INLINE float local_reward(const Skill *skill, const Cell *cell_tm1, const Cell *cell_t)
{
    const float turn = cell_t->bits & PREY_BIT ? 0.0f : wrapped(cell_t->angle - cell_tm1->angle);
    const float gain = cell_tm1->distance - cell_t->distance;
    return skill->gain * gain + skill->arc * (turn * cell_tm1->distance) +
           skill->inward * (gain > 0.0f ? gain : 0.0f);
}

/* The next draw; the one after it is made now, so that a step never waits for its own. */
ALWAYS_INLINE uint64_t take(uint64_t *counter, uint64_t *next)
{
    const uint64_t draw = *next;
    *counter += GAMMA;
    *next = mix(*counter + GAMMA);
    return draw;
}

/* The option that a running episode imposes on a step, and the options left if none does. */
ALWAYS_INLINE uint32_t imposed_option(const Phase *phase, uint64_t *counter, uint64_t *next,
                                      uint32_t *allowed)
{
    for (int episode = 0; episode < phase->n_episodes; episode++) {
        const uint32_t option = phase->episode_option[episode];
        if (take(counter, next) >> 32 < phase->episode_chance[episode]) return option;
        *allowed &= ~(1u << option);
    }
    if (*allowed == 0) *allowed = phase->present;
    return NO_OPTION;
}

/* Trials up to one, by the rules of a phase; what kind of steps they have is constant. */
ALWAYS_INLINE void run_trials(Learner *learner, const Phase *phase, int64_t until,
                              const bool moves, const bool episodes, const bool frozen)
{
    const Settings *settings = &learner->settings;
    const Cell *const cells = learner->cells;
    const int32_t *const move_step = learner->move_step;
    const uint32_t epsilon16 = (uint32_t)nearbyint(settings->epsilon * 65536.0);
    const uint32_t present = phase->present;
    const float alpha = phase->alpha, skill_alpha = settings->skill_alpha;
    const float gamma = settings->gamma;
    const int step_limit = settings->world.step_limit;
    const uint32_t shift = learner->skill_shift;
    uint64_t counter = learner->decisions;
    uint64_t next = mix(counter + GAMMA);

    while (learner->trial < until) {
        const uint32_t seen_bit = 1u << learner->heading;
        const uint32_t event_bits = seen_bit | PREY_BIT;
        Row *const selection = learner->selection + learner->heading * learner->n_skill_states;
        uint32_t cell = learner->cell;
        uint32_t state = cells[cell].state;
        int trial_step = 0;
        for (;;) {
            uint32_t option = NO_OPTION, allowed = present;
            if (episodes) option = imposed_option(phase, &counter, &next, &allowed);
            const uint64_t draw = take(&counter, &next);
            if (!episodes || option == NO_OPTION) {
                const uint32_t index16 = (uint32_t)(draw >> 16) & 0xFFFF;
                uint32_t members = selection[state].greedy;
                if (UNLIKELY((draw & 0xFFFF) < epsilon16)) {
                    if (moves)
                        option = (index16 * N_MOVES) >> 16;
                    else
                        option = pick(allowed, index16);
                } else if (moves && members == (1u << N_MOVES) - 1) {
                    option = (index16 * N_MOVES) >> 16;
                } else {
                    if (episodes) {
                        members &= allowed;
                        if (members == 0) members = greedy_by_scan(&selection[state], allowed);
                    }
                    option = pick(members, index16);
                }
            }
            uint32_t move = option;
            if (!moves) {
                const uint32_t index16 = (uint32_t)(draw >> 48);
                if (UNLIKELY(((uint32_t)(draw >> 32) & 0xFFFF) < epsilon16))
                    move = (index16 * N_MOVES) >> 16;
                else
                    move = pick(learner->skills[(state << shift) + option].greedy, index16);
            }

            uint32_t cell_t = cell + (uint32_t)move_step[move];
            const uint32_t bits_t = cells[cell_t].bits;
            if (UNLIKELY(bits_t & FRAME_BIT)) cell_t = learner->clipped[cell_t];
            const uint32_t state_t = cells[cell_t].state;
            trial_step++;

            float reward = 0.0f;
            bool ended = false;
            if (UNLIKELY(bits_t & event_bits)) {
                const uint32_t judged = bits_t & PREY_BIT ? cells[cell].bits : bits_t;
                if ((judged & seen_bit) && cells[cell_t].distance < cells[cell].distance) {
                    learner->flights++;
                    reward = settings->world.flight_reward;
                    ended = true;
                } else if (bits_t & PREY_BIT) {
                    learner->captures++;
                    reward = settings->world.capture_reward;
                    ended = true;
                }
            }
            if (!frozen) {
                const float target = ended ? reward : gamma * selection[state_t].best;
                backup(&selection[state], option, target, alpha);
            }
            if (!moves) {
                Row *const skill = learner->skills + option;
                const float r_t =
                    local_reward(&settings->skills[option], &cells[cell], &cells[cell_t]);
                const float target = r_t + gamma * skill[state_t << shift].best;
                backup(&skill[state << shift], move, target, skill_alpha);
            }
            cell = cell_t;
            state = state_t;
            if (ended) break;
            if (UNLIKELY(trial_step == step_limit)) {
                learner->timeouts++;
                break;
            }
        }
        learner->step += trial_step;
        learner->trial++;
        start_of_trial(learner);
    }
    learner->decisions = counter;
}

#define SPECIALISED(name, moves, episodes, frozen)                                             \
    static NOINLINE void name(Learner *learner, const Phase *phase,           \
                                               int64_t until)                                  \
    {                                                                                          \
        run_trials(learner, phase, until, moves, episodes, frozen);                            \
    }
SPECIALISED(run_moves, true, false, false)
SPECIALISED(run_skills, false, false, false)
SPECIALISED(run_skills_frozen, false, false, true)
SPECIALISED(run_skills_episodes, false, true, false)
SPECIALISED(run_skills_episodes_frozen, false, true, true)

/* ------------------------------------------------------------------ the schedule */

static void join(Learner *learner, int option)
{
    for (size_t i = 0; i < learner->n_skill_states * N_HEADINGS; i++) {
        Row *row = &learner->selection[i];
        const float initial = learner->settings.initial_q;
        const bool is_worse =
            learner->settings.safe_introduction && row->greedy && row->best < initial;
        rescan(row, (uint32_t)option, is_worse ? row->best : initial);
    }
}

/* Let skills join that are due, and find what holds until the next event. Returns its trial. */
static int64_t next_phase(Learner *learner, Phase *phase)
{
    const Settings *settings = &learner->settings;
    const int64_t trial = learner->trial;
    int64_t event = settings->trials;
#define EVENT(when)                                                                            \
    do {                                                                                       \
        const int64_t when_ = (when);                                                          \
        if (when_ > trial && when_ < event) event = when_;                                     \
    } while (0)
    phase->alpha = settings->alpha;
    phase->n_episodes = 0;
    if (settings->moves) {
        phase->present = (1u << N_MOVES) - 1;
        return event;
    }
    for (int option = 0; option < settings->n_skills; option++) {
        const Skill *skill = &settings->skills[option];
        if (skill->at == trial && !(phase->present >> option & 1)) {
            join(learner, option);
            phase->present |= 1u << option;
        }
        if (skill->at <= trial && trial < skill->at + skill->freeze) phase->alpha = 0.0f;
        EVENT(skill->at);
        EVENT(skill->at + skill->freeze);
    }
    /* The newest first: given in the order of their age, they are walked from the end. */
    for (int i = settings->n_episodes - 1; i >= 0; i--) {
        const Episode *episode = &settings->episodes[i];
        const int64_t end = episode->start + episode->duration;
        EVENT(episode->start);
        EVENT(end);
        if (episode->start > trial || trial >= end) continue;
        phase->episode_option[phase->n_episodes] = episode->option;
        phase->episode_chance[phase->n_episodes] =
            (uint64_t)nearbyint(episode->probability * 4294967296.0);
        phase->n_episodes++;
    }
    return event;
#undef EVENT
}

static void run(Learner *learner)
{
    Phase phase = {0};
    start_of_trial(learner);
    while (learner->trial < learner->settings.trials) {
        const int64_t until = next_phase(learner, &phase);
        const bool frozen = phase.alpha == 0.0f;
        if (learner->settings.moves)
            run_moves(learner, &phase, until);
        else if (phase.n_episodes)
            (frozen ? run_skills_episodes_frozen : run_skills_episodes)(learner, &phase, until);
        else
            (frozen ? run_skills_frozen : run_skills)(learner, &phase, until);
    }
}

/* ------------------------------------------------------------------ preparation */

static void fill(Row *table, size_t n_rows, int n_actions, float value)
{
    for (size_t i = 0; i < n_rows; i++) {
        for (int action = 0; action < MAX_ACTIONS; action++) table[i].q[action] = -INFINITY;
        table[i].greedy = 0;
        for (int action = 0; action < n_actions; action++)
            rescan(&table[i], (uint32_t)action, value);
    }
}

static void prepare(Learner *learner)
{
    const WorldSettings *world = &learner->settings.world;
    const int size = world->size, width = size + 2, prey = size / 2;
    const double scale = size / 120.0, vision = world->vision_radius * scale;
    const double far_axis = prey > size - 1 - prey ? prey : size - 1 - prey;
    const double far = hypot(far_axis, far_axis);
    const double sector = 2 * M_PI / world->n_directions;
    static const int facing[N_HEADINGS][2] = {{1, 0},  {1, 1},   {0, 1},  {-1, 1},
                                              {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
    learner->n_skill_states = (size_t)world->n_directions * world->n_distances;
    learner->cells = table_memory((size_t)width * width * sizeof(Cell));
    learner->clipped = table_memory((size_t)width * width * sizeof(uint32_t));
    for (int fy = 0; fy < width; fy++) {
        for (int fx = 0; fx < width; fx++) {
            const int x = fx < 1 ? 0 : fx > size ? size - 1 : fx - 1;
            const int y = fy < 1 ? 0 : fy > size ? size - 1 : fy - 1;
            const int dx = x - prey, dy = y - prey;
            Cell *cell = &learner->cells[fy * width + fx];
            const double distance = hypot(dx, dy), angle = atan2(dy, dx);
            const int turns = (int)floor(angle / sector + 0.5);
            const int direction = (turns + world->n_directions) % world->n_directions;
            int ring = 0;
            while (ring < world->n_distances - 1 &&
                   far * pow((ring + 1.0) / world->n_distances, world->ring_exponent) <
                       distance * (1 - 1e-12))
                ring++;
            cell->state = (uint32_t)(ring * world->n_directions + direction);
            cell->bits = x != fx - 1 || y != fy - 1 ? FRAME_BIT : 0;
            if (dx == 0 && dy == 0) cell->bits |= PREY_BIT;
            if (dx * dx + dy * dy <= vision * vision)
                for (int heading = 0; heading < N_HEADINGS; heading++)
                    if (facing[heading][0] * dx + facing[heading][1] * dy > 0)
                        cell->bits |= 1u << heading;
            cell->distance = (float)distance;
            cell->angle = (float)angle;
            learner->clipped[fy * width + fx] = (uint32_t)((y + 1) * width + x + 1);
        }
    }
    for (int move = 0; move < N_MOVES; move++)
        learner->move_step[move] = (move / 3 - 1) * width + move % 3 - 1;

    const Settings *settings = &learner->settings;
    const size_t n_states = learner->n_skill_states * N_HEADINGS;
    while (1 << learner->skill_shift < settings->n_skills) learner->skill_shift++;
    const size_t n_skill_rows = learner->n_skill_states << learner->skill_shift;
    learner->selection = table_memory(n_states * sizeof(Row));
    learner->skills = table_memory(n_skill_rows * sizeof(Row));
    fill(learner->selection, n_states, settings->moves ? N_MOVES : 0,
         settings->initial_q);
    fill(learner->skills, n_skill_rows, N_MOVES, settings->initial_q);
    learner->decisions = mix(settings->seed + GAMMA);
    learner->starts = mix(settings->seed + 2 * GAMMA);
}

/* ------------------------------------------------------------------ command line */

static void usage(const char *problem)
{
    fprintf(stderr,
            "learner: %s\n"
            "usage: learner [--NAME VALUE ...]\n"
            "  world     --size --directions --distances --vision --start NEAREST FARTHEST\n"
            "            --step-limit --capture --flight   (lengths as for a grid of 120)\n"
            "  learner   --alpha --skill-alpha --gamma --epsilon --initial-q\n"
            "  options   the nine moves, or one for each --skill GAIN ARC INWARD AT FREEZE\n"
            "            --safe-introduction 0 or 1\n"
            "  episodes  --episode SKILL START DURATION PROBABILITY   (skills count from 0;\n"
            "            the oldest first)\n"
            "  run       --seed --trials\n",
            problem);
    exit(2);
}

static double number(char **text)
{
    char *end;
    if (!*text) usage("a value is missing");
    const double value = strtod(*text, &end);
    if (end == *text || *end) usage("not a number");
    return value;
}

static uint64_t integer(char **text)
{
    char *end;
    if (!*text) usage("a value is missing");
    const uint64_t value = strtoull(*text, &end, 10);
    if (end == *text || *end) usage("not a whole number");
    return value;
}

static Settings parse(char **argument)
{
    Settings s = {
        .world = {120, 24, 18, 500, 1.5, 27.0, 10.0, 60.0, 100.0f, -50.0f},
        .moves = true,
        .safe_introduction = true,
        .alpha = 0.6f,
        .skill_alpha = 0.6f,
        .gamma = 0.9f,
        .epsilon = 0.1,
        .trials = 1000,
    };
    while (*argument) {
        const char *name = *argument++;
#define TAKES(text) (strcmp(name, text) == 0)
#define NUMBER() number(argument++)
        if (TAKES("--size")) s.world.size = (int)NUMBER();
        else if (TAKES("--directions")) s.world.n_directions = (int)NUMBER();
        else if (TAKES("--distances")) s.world.n_distances = (int)NUMBER();
        else if (TAKES("--ring-exponent")) s.world.ring_exponent = NUMBER();
        else if (TAKES("--vision")) s.world.vision_radius = NUMBER();
        else if (TAKES("--start")) {
            s.world.start_nearest = NUMBER();
            s.world.start_farthest = NUMBER();
        }
        else if (TAKES("--step-limit")) s.world.step_limit = (int)NUMBER();
        else if (TAKES("--capture")) s.world.capture_reward = (float)NUMBER();
        else if (TAKES("--flight")) s.world.flight_reward = (float)NUMBER();
        else if (TAKES("--alpha")) s.alpha = (float)NUMBER();
        else if (TAKES("--skill-alpha")) s.skill_alpha = (float)NUMBER();
        else if (TAKES("--gamma")) s.gamma = (float)NUMBER();
        else if (TAKES("--epsilon")) s.epsilon = NUMBER();
        else if (TAKES("--initial-q")) s.initial_q = (float)NUMBER();
        else if (TAKES("--safe-introduction")) s.safe_introduction = integer(argument++) != 0;
        else if (TAKES("--seed")) s.seed = integer(argument++);
        else if (TAKES("--trials")) s.trials = (int64_t)integer(argument++);
        else if (TAKES("--skill")) {
            if (s.n_skills == MAX_SKILLS) usage("too many skills");
            Skill *skill = &s.skills[s.n_skills++];
            skill->gain = (float)NUMBER();
            skill->arc = (float)NUMBER();
            skill->inward = (float)NUMBER();
            skill->at = (int64_t)NUMBER();
            skill->freeze = (int64_t)NUMBER();
            s.moves = false;
        }
        else if (TAKES("--episode")) {
            if (s.n_episodes == MAX_EPISODES) usage("too many episodes");
            Episode *episode = &s.episodes[s.n_episodes++];
            episode->option = (uint32_t)NUMBER();
            episode->start = (int64_t)NUMBER();
            episode->duration = (int64_t)NUMBER();
            episode->probability = NUMBER();
        }
        else usage(name);
    }
    for (int i = 0; i < s.n_episodes; i++)
        if (s.episodes[i].option >= (uint32_t)s.n_skills) usage("an episode of no skill");
    const double scale = s.world.size / 120.0;
    s.world.start_nearest *= scale;
    s.world.start_farthest *= scale;
    return s;
}

/* ------------------------------------------------------------------ result */

static uint64_t checksum(const Learner *learner)
{
    const size_t n_options = learner->settings.moves ? N_MOVES : learner->settings.n_skills;
    uint64_t sum = 0, place = 0;
    for (size_t row = 0; row < learner->n_skill_states * N_HEADINGS; row++) {
        for (size_t option = 0; option < n_options; option++) {
            uint32_t word;
            memcpy(&word, &learner->selection[row].q[option], sizeof word);
            place += GAMMA;
            sum += mix(place ^ word);
        }
    }
    return sum;
}

static double thread_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

int main(int argc, char **argv)
{
    (void)argc;
    Learner learner = {.settings = parse(argv + 1)};
    prepare(&learner);
    const double start = thread_seconds();
    run(&learner);
    const double seconds = thread_seconds() - start;
    printf("{\"steps\": %lld, \"captures\": %lld, \"flights\": %lld, \"timeouts\": %lld, "
           "\"checksum\": \"%016llx\", \"seconds\": %.9f}\n",
           (long long)learner.step, (long long)learner.captures, (long long)learner.flights,
           (long long)learner.timeouts, (unsigned long long)checksum(&learner), seconds);
    return 0;
}
