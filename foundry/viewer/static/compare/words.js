"use strict";
/* Finds the differences between two texts, word by word, and the sections of a prompt. */
(function (foundry) {
  const TOKEN = /[\p{Script=Han}\p{Script=Hiragana}\p{Script=Katakana}]|[\p{L}\p{N}\p{M}_]+|\n|[^\S\n]+|[^]/gu;
  const HEADING = /^\s*(?:={2,}\s*\S.*={2,}|#{1,6}\s+\S.*|【.+】|<\w[\w -]*>|\*\*[^*]+\*\*:?)\s*$/;
  const BLANK = /^[^\S\n]+$/;
  const SAME = "same", GONE = "gone", NEW = "new";
  /**
   * If texts differ in more words than this, they count as different as a whole, because time and memory grow with the
   * square of the number.
   */
  const MOST_EDITS = 1000;
  /** A prompt with more headings than this is not folded by headings. */
  const MOST_SECTIONS = 100;

  /**
   * Return the shortest list of edits, [kind, word] each, that changes one list of words into another; null if there are too many.
   * Myers (1986), An O(ND) difference algorithm and its variations.
   */
  function edits(a, b) {
    const most = Math.min(MOST_EDITS, a.length + b.length), middle = most + 1, rounds = [];
    const reach = new Int32Array(2 * most + 3);
    for (let round = 0; round <= most; round += 1) {
      rounds.push(reach.slice(middle - round - 1, middle + round + 2));
      for (let way = -round; way <= round; way += 2) {
        const at = middle + way, down = way === -round || (way !== round && reach[at - 1] < reach[at + 1]);
        let x = down ? reach[at + 1] : reach[at - 1] + 1;
        while (x < a.length && x - way < b.length && a[x] === b[x - way]) x += 1;
        reach[at] = x;
        if (x >= a.length && x - way >= b.length) return backwards(a, b, rounds);
      }
    }
    return null;
  }

  function backwards(a, b, rounds) {
    const words = [];
    let x = a.length, y = b.length;
    for (let round = rounds.length - 1; round >= 0; round -= 1) {
      const reach = rounds[round], middle = round + 1, way = x - y;
      const down = way === -round || (way !== round && reach[middle + way - 1] < reach[middle + way + 1]);
      const before = down ? way + 1 : way - 1, fromX = reach[middle + before], fromY = fromX - before;
      for (; x > fromX && y > fromY; x -= 1, y -= 1) words.push([SAME, a[x - 1]]);
      if (round) words.push(down ? [NEW, b[fromY]] : [GONE, a[fromX]]);
      [x, y] = [fromX, fromY];
    }
    return words.reverse();
  }

  /** Join words to parts. A blank between two changes belongs to both, so that a changed phrase is one piece. */
  function joined(words) {
    const parts = [];
    let changed = {gone: "", new: ""}, blank = "";
    const add = (kind, text) => {
      const last = parts[parts.length - 1];
      if (last && last[0] === kind) last[1] += text;
      else if (text) parts.push([kind, text]);
    };
    const close = () => {
      add(GONE, changed.gone);
      add(NEW, changed.new);
      add(SAME, blank);
      changed = {gone: "", new: ""};
      blank = "";
    };
    for (const [kind, text] of words) {
      if (kind === SAME && (changed.gone || changed.new) && !blank && BLANK.test(text)) blank = text;
      else if (kind === SAME) { close(); add(SAME, text); } else {
        changed.gone += blank;
        changed.new += blank;
        blank = "";
        changed[kind] += text;
      }
    }
    close();
    return parts;
  }

  /**
   * Return the parts of two texts in order, [kind, text] each: "same", "gone" (only in the first text), "new" (only in
   * the second text).
   */
  function difference(before, after) {
    if (before === after) return before ? [[SAME, before]] : [];
    const a = before.match(TOKEN) || [], b = after.match(TOKEN) || [], least = Math.min(a.length, b.length);
    let head = 0, tail = 0;
    while (head < least && a[head] === b[head]) head += 1;
    while (tail < least - head && a[a.length - 1 - tail] === b[b.length - 1 - tail]) tail += 1;
    const [x, y] = [a.slice(head, a.length - tail), b.slice(head, b.length - tail)];
    const middle = edits(x, y) || [[GONE, x.join("")], [NEW, y.join("")]];
    return joined([[SAME, a.slice(0, head).join("")], ...middle, [SAME, a.slice(a.length - tail).join("")]]);
  }

  /** Return the sections of a prompt, [heading, text] each. The text before the first heading has an empty heading. */
  function sections(text) {
    const parts = [["", []]];
    for (const line of text.split("\n")) {
      if (HEADING.test(line)) parts.push([line.trim(), []]);
      else parts[parts.length - 1][1].push(line);
    }
    if (parts.length > MOST_SECTIONS) return [["", text]];
    return parts.map(([heading, lines]) => [heading, lines.join("\n")]).filter(([heading, body]) => heading || body);
  }

  foundry.words = {difference, sections, SAME, GONE, NEW};
})(window.Foundry);
