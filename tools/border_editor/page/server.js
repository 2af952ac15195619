// The requests of the page; the server computes all geometry.

const token = new URLSearchParams(location.search).get("token") ?? "";

export async function site() {
  const answer = await fetch("/site.json");
  return answer.json();
}

export async function ask(what, content = {}) {
  const answer = await fetch(`/${what}?token=${encodeURIComponent(token)}`, {
    method: "POST",
    body: JSON.stringify(content),
  });
  if (!answer.ok) throw new Error(await answer.text());
  return answer.json();
}
